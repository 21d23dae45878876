#include "ugoki/content/delta.h"

#include <algorithm>

namespace ugoki::content {
namespace {

bool same_fields(const Json& a, const Json& b) {
  if (a.size() != b.size()) return false;
  auto i = a.begin();
  for (auto j = b.begin(); j != b.end(); ++i, ++j)
    if (i.key() != j.key()) return false;
  return true;
}

/// True if the values and the order of all fields are equal.
bool identical(const Json& a, const Json& b) {
  if (a.type() != b.type()) return false;
  if (a.is_object()) {
    if (!same_fields(a, b)) return false;
    for (auto i = a.begin(), j = b.begin(); i != a.end(); ++i, ++j)
      if (!identical(i.value(), j.value())) return false;
    return true;
  }
  if (a.is_array()) return std::equal(a.begin(), a.end(), b.begin(), b.end(), identical);
  return a == b;
}

std::size_t index_in(const Json& value) { return value.is_number_unsigned() ? value.get<std::size_t>() : static_cast<std::size_t>(-1); }

/// Applies the delta in place. Returns false if the delta does not fit `target`, which may then be partly changed.
bool apply(Json& target, const Json& delta) {
  if (!delta.is_object() || delta.size() != 1) return false;
  const std::string& kind = delta.begin().key();
  const Json& body = delta.begin().value();
  if (kind == "v") {
    target = body;
    return true;
  }
  if (kind == "o") {
    if (!target.is_object() || !body.is_object()) return false;
    for (auto i = body.begin(); i != body.end(); ++i) {
      const auto field = target.find(i.key());
      if (field == target.end() || !apply(*field, i.value())) return false;
    }
    return true;
  }
  if (!target.is_array() || !body.is_array()) return false;
  if (kind == "a") {
    for (const Json& change : body) {
      if (!change.is_array() || change.size() != 2) return false;
      const std::size_t i = index_in(change[0]);
      if (i >= target.size() || !apply(target[i], change[1])) return false;
    }
    return true;
  }
  if (kind != "s" || body.size() != 3 || !body[2].is_array()) return false;
  const std::size_t at = index_in(body[0]), count = index_in(body[1]);
  if (at > target.size() || count > target.size() - at) return false;
  Json out = Json::array();
  for (std::size_t i = 0; i < at; ++i) out.push_back(std::move(target[i]));
  for (const Json& value : body[2]) out.push_back(value);
  for (std::size_t i = at + count; i < target.size(); ++i) out.push_back(std::move(target[i]));
  target = std::move(out);
  return true;
}

}  // namespace

Json make_delta(const Json& from, const Json& to) {
  if (identical(from, to)) return nullptr;
  if (from.is_object() && to.is_object() && same_fields(from, to)) {
    Json fields = Json::object();
    for (auto i = from.begin(), j = to.begin(); i != from.end(); ++i, ++j)
      if (Json change = make_delta(i.value(), j.value()); !change.is_null()) fields[i.key()] = std::move(change);
    return {{"o", std::move(fields)}};
  }
  if (from.is_array() && to.is_array() && from.size() == to.size()) {
    Json entries = Json::array();
    for (std::size_t i = 0; i < from.size(); ++i)
      if (Json change = make_delta(from[i], to[i]); !change.is_null()) entries.push_back(Json::array({i, std::move(change)}));
    return {{"a", std::move(entries)}};
  }
  if (from.is_array() && to.is_array()) {
    const std::size_t shorter = std::min(from.size(), to.size());
    std::size_t head = 0, tail = 0;
    while (head < shorter && identical(from[head], to[head])) ++head;
    while (tail < shorter - head && identical(from[from.size() - 1 - tail], to[to.size() - 1 - tail])) ++tail;
    Json values = Json::array();
    for (std::size_t i = head; i < to.size() - tail; ++i) values.push_back(to[i]);
    return {{"s", Json::array({head, from.size() - tail - head, std::move(values)})}};
  }
  return {{"v", to}};
}

Result<Json> apply_delta(const Json& from, const Json& delta) {
  Json out = from;
  if (!apply(out, delta))
    return fail(ErrorCode::structure, "history", "A step of the history does not fit the document.",
                "Undo and redo cannot continue past this step; the document is unchanged.");
  return out;
}

}  // namespace ugoki::content
