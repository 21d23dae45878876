#include "ugoki/content/circuit_edit.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "ugoki/circuit/circuit.h"

namespace ugoki::content {
namespace {

constexpr std::array<std::string_view, 8> lists = {"inputs", "outputs", "parameters", "lsis", "wires", "notes", "probes", "circuits"};
constexpr std::array<std::string_view, 4> settings = {"name", "doc", "inputs_at", "outputs_at"};

bool is_one_of(std::string_view word, std::span<const std::string_view> words) {
  for (const std::string_view w : words)
    if (w == word) return true;
  return false;
}

/// Returns the key of an item of `list`; std::nullopt: no key. `item` is a whole item, or the value of a change's field `take`.
std::optional<std::string> key_of(std::string_view list, const Json& item) {
  const auto text = [&](const char* field) -> std::optional<std::string> {
    const auto it = item.find(field);
    if (it == item.end() || !it->is_string()) return std::nullopt;
    return it->get<std::string>();
  };
  if (item.is_string()) return list == "wires" ? std::nullopt : std::optional(item.get<std::string>());
  if (!item.is_object()) return std::nullopt;
  if (list == "wires") {
    const auto from = text("from"), to = text("to");
    return from && to ? std::optional(*from + "\n" + *to) : std::nullopt;
  }
  if (list == "lsis" || list == "notes") return text("id");
  return text(list == "probes" ? "pin" : "name");
}

/// One list of a circuit while changes are applied. A removed item is null until finish(), so that indices stay valid.
class List {
 public:
  List(Json& items, std::string_view name) : items_(&items), name_(name) {
    for (std::size_t i = 0; i < items.size(); ++i)
      if (const auto key = key_of(name, items[i])) index_.emplace(*key, i);
  }
  void put(const std::string& key, const Json& item) {
    const auto [it, added] = index_.emplace(key, items_->size());
    if (added)
      items_->push_back(item);
    else
      (*items_)[it->second] = item;
  }
  bool take(const std::string& key) {
    const auto it = index_.find(key);
    if (it == index_.end()) return false;
    (*items_)[it->second] = nullptr;
    index_.erase(it);
    return true;
  }
  void finish() {
    Json kept = Json::array();
    for (Json& item : *items_)
      if (!item.is_null()) kept.push_back(std::move(item));
    *items_ = std::move(kept);
  }

 private:
  Json* items_;
  std::string_view name_;
  std::unordered_map<std::string, std::size_t> index_;
};

class Editor {
 public:
  Editor(Json& circuit, Error& problems) : circuit_(circuit), problems_(problems) {}

  void apply(const Json& change, const std::string& path) {
    Fields f(change, path, problems_);
    if (!f.is_object()) return;
    Json* circuit = find_circuit(f);
    std::string list;
    f.text("list", list);
    const Json *put = f.find("put"), *take = f.find("take"), *set = f.find("set");
    f.refuse_others();
    if (!circuit || !problems_.empty()) return;
    if ((put != nullptr) + (take != nullptr) + (set != nullptr) != 1) {
      f.report(ErrorCode::structure, path, "A change must have exactly one of the fields put, take and set.",
               "Split it into several changes.");
    } else if (set) {
      set_fields(*circuit, *set, f.path("set"));
    } else if (!is_one_of(list, lists)) {
      f.report(ErrorCode::unknown, f.path("list"), "A circuit has no list '" + list + "'.",
               "Use lsis, wires, notes, probes, circuits, inputs, outputs or parameters.");
    } else if (const auto key = key_of(list, put ? *put : *take); !key) {
      f.report(ErrorCode::syntax, f.path(put ? "put" : "take"), "The change does not identify an item of '" + list + "'.",
               "Give its id, name or pin; for a wire, give both ends.");
    } else if (put) {
      if (put->is_object())
        list_in(*circuit, list).put(*key, *put);
      else
        f.report(ErrorCode::syntax, f.path("put"), "The value must be an object.", "Give the whole item.");
    } else if (!list_in(*circuit, list).take(*key)) {
      f.report(ErrorCode::unknown, f.path("take"), "The list '" + list + "' does not contain this item.",
               "It may have been removed; reload the circuit.");
    }
    if (list == "circuits") finish_lists();
  }

  /// Writes the changed lists back to the circuit.
  void finish_lists() {
    for (auto& [key, list] : open_) list.finish();
    open_.clear();
    found_ = nullptr;  // inner circuits may have moved in memory
  }

 private:
  /// Returns the circuit that field `in` of a change names, from the outermost circuit inwards. If there is none, returns null and adds a
  /// problem. The last result is cached, because an editor sends many changes of one circuit.
  Json* find_circuit(Fields& f) {
    const Json* names = f.find("in");
    if (!names) return &circuit_;
    std::string joined_names;
    if (names->is_array())
      for (const Json& name : *names) joined_names += name.is_string() ? name.get<std::string>() + "\n" : "";
    if (joined_names == found_names_ && found_) return found_;
    finish_lists();
    Json* at = names->is_array() ? &circuit_ : nullptr;
    for (std::size_t i = 0; at && i < names->size(); ++i) {
      const Json& name = (*names)[i];
      const auto inner = at->find("circuits");
      Json* next = nullptr;
      if (name.is_string() && inner != at->end() && inner->is_array())
        for (Json& c : *inner)
          if (c.is_object() && c.find("name") != c.end() && c["name"] == name) next = &c;
      at = next;
    }
    if (!at)
      f.report(ErrorCode::unknown, f.path("in"), "The circuit has no inner circuit of this name.",
               "Name the circuits from the outermost one inwards.");
    found_names_ = std::move(joined_names);
    found_ = at;
    return at;
  }

  List& list_in(Json& circuit, const std::string& name) {
    const auto key = std::pair(&circuit, name);
    if (const auto it = open_.find(key); it != open_.end()) return it->second;
    if (!circuit.contains(name)) finish_lists();  // adding a field moves the other lists in memory
    Json& items = circuit[name];
    if (!items.is_array()) items = Json::array();
    const auto known = std::find(lists.begin(), lists.end(), name);
    return open_.emplace(key, List(items, *known)).first->second;
  }

  void set_fields(Json& circuit, const Json& fields, const std::string& path) {
    if (!fields.is_object()) {
      problems_.add(ErrorCode::syntax, path, "The value must be an object.", "Give the fields to set.");
      return;
    }
    finish_lists();  // adding a field may move the lists in memory
    for (auto it = fields.begin(); it != fields.end(); ++it) {
      if (!is_one_of(it.key(), settings)) {
        problems_.add(ErrorCode::unknown, path + "/" + it.key(), "'" + it.key() + "' cannot be set.",
                      "Use name, doc, inputs_at or outputs_at.");
      } else if (it->is_null()) {
        circuit.erase(it.key());
      } else {
        circuit[it.key()] = *it;
      }
    }
  }

  Json& circuit_;
  Error& problems_;
  std::map<std::pair<Json*, std::string>, List> open_;
  std::string found_names_;  ///< names from the last find_circuit(), one a line: from the outermost circuit to `found_`
  Json* found_ = nullptr;    ///< result of the last find_circuit(); null: none or no longer valid
};

}  // namespace

void apply_circuit_changes(Json& circuit, const Json& changes, const std::string& path, Error& problems) {
  if (!changes.is_array()) {
    problems.add(ErrorCode::syntax, path, "The value must be a list of changes.", "Write it as [ ... ].");
    return;
  }
  Editor editor(circuit, problems);
  for (std::size_t i = 0; i < changes.size() && problems.empty(); ++i) editor.apply(changes[i], path + "/" + std::to_string(i));
  editor.finish_lists();
}

Error check_circuit_form(const Json& circuit) {
  const Result<circuit::Circuit> read = circuit::read_circuit(to_text(circuit));
  return read ? Error() : read.error();
}

}  // namespace ugoki::content
