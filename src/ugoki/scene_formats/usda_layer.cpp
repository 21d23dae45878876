#include "ugoki/scene_formats/usda_layer.h"

#include <algorithm>
#include <array>

#include "ugoki/formats/text.h"

namespace ugoki::scene_formats {
namespace {

constexpr int max_nesting = 200;
constexpr std::size_t max_prims = 200'000;

bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ':' || c == '.' ||
         static_cast<unsigned char>(c) >= 0x80;
}
bool is_number(char c) { return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.'; }

/// Returns whether an attribute is kept.
bool is_wanted(std::string_view name) {
  constexpr std::array kept = {"joints", "bindTransforms", "restTransforms", "translations", "rotations", "scales", "xformOpOrder"};
  return name.starts_with("xformOp:") || std::ranges::find(kept, name) != kept.end();
}

/// The path of a target, which may be relative to the prim at `prim`, without its property.
std::string absolute(std::string_view target, std::string_view prim) {
  std::string path = target.starts_with('/') ? std::string() : std::string(prim);
  while (target.starts_with("../") || target == "..") {
    target.remove_prefix(std::min<std::size_t>(3, target.size()));
    path.resize(path.empty() ? 0 : path.rfind('/'));
  }
  if (!target.empty() && !target.starts_with('/')) path += '/';
  path += target;
  return path.substr(0, path.find('.'));
}

class Parser {
 public:
  Parser(std::string_view text, std::string_view file_name) : text_(text), problems_(file_name) {}

  Result<UsdLayer> read() {
    const std::optional<std::string_view> plain = formats::plain_text(text_, "USD", problems_);
    if (!plain) return fail(problems_.take());
    text_ = *plain;
    if (!text_.starts_with("#usda")) {
      refuse("The file does not begin with '#usda'.", "Save it as USD text (.usda).");
      return fail(problems_.take());
    }
    const bool good = (!accept('(') || metadata(-1)) && body(-1, false, 0);
    if (good && more()) refuse("Unexpected character " + formats::in_quotes(text_.substr(at_, 1)) + ".", "Correct the file.");
    if (!problems_.empty()) return fail(problems_.take());
    for (UsdPrim& prim : layer_.prims)
      for (auto& [name, attribute] : prim.attributes)
        std::ranges::sort(attribute.samples, {}, [](const auto& sample) { return sample.first; });
    return std::move(layer_);
  }

 private:
  bool refuse(std::string message, std::string remedy) {
    if (problems_.empty()) problems_.add(ErrorCode::syntax, line_, std::move(message), std::move(remedy));
    return false;
  }
  bool expected(const char* what) {
    return refuse(more() ? "Expected " + std::string(what) + ", found " + formats::in_quotes(text_.substr(at_, 1)) + "."
                         : "The file ends where " + std::string(what) + " is expected.",
                  "Export the file again.");
  }

  /// Skips white space, separators of statements and comments. Returns false at the end of the text.
  bool more() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n') ++line_;
      if (c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ';') {
        ++at_;
      } else if (c == '#' || text_.substr(at_, 2) == "//") {
        at_ = std::min(text_.size(), text_.find('\n', at_));
      } else if (text_.substr(at_, 2) == "/*") {
        const std::size_t end = std::min(text_.size(), text_.find("*/", at_ + 2));
        line_ += static_cast<int>(std::ranges::count(text_.substr(at_, end - at_), '\n'));
        at_ = std::min(text_.size(), end + 2);
      } else {
        return true;
      }
    }
    return false;
  }
  bool next_is(char c) { return more() && text_[at_] == c; }
  bool accept(char c) {
    if (!next_is(c)) return false;
    ++at_;
    return true;
  }
  std::string_view word() {
    if (!more()) return {};
    const std::size_t from = at_;
    while (at_ < text_.size() && is_word(text_[at_])) ++at_;
    return text_.substr(from, at_ - from);
  }

  /// Reads a text in quotes: "a", 'a', """a""" or '''a'''. Escape sequences stay as they are, except \" \' and \\.
  bool quoted(std::string* out) {
    if (!more() || (text_[at_] != '"' && text_[at_] != '\'')) return expected("a text in quotes");
    const char quote = text_[at_];
    const bool block = text_.substr(at_, 3) == std::string(3, quote);
    at_ += block ? 3 : 1;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == quote && (!block || text_.substr(at_, 3) == std::string(3, quote))) {
        at_ += block ? 3 : 1;
        return true;
      }
      if (c == '\n' && !block) break;
      if (c == '\n') ++line_;
      const bool escape = c == '\\' && at_ + 1 < text_.size();
      if (escape) ++at_;
      if (out) *out += text_[at_];
      if (escape && text_[at_] == '\n') ++line_;
      ++at_;
    }
    return refuse("A text in quotes does not end.", "Add the closing quote.");
  }
  /// Reads a path <a> or an asset @a@ or @@@a@@@.
  bool enclosed(std::string_view begin, std::string_view end, std::string* out = nullptr) {
    const std::size_t to = text_.find(end, at_ + begin.size());
    if (to == std::string_view::npos || text_.substr(at_, to - at_).contains('\n'))
      return refuse(formats::in_quotes(begin) + " without its " + formats::in_quotes(end) + ".", "Correct the file.");
    if (out) *out = text_.substr(at_ + begin.size(), to - at_ - begin.size());
    at_ = to + end.size();
    return true;
  }
  bool asset() { return text_.substr(at_, 3) == "@@@" ? enclosed("@@@", "@@@") : enclosed("@", "@"); }

  /// Skips a value, or everything up to the bracket that closes the one at the present place.
  bool skip() {
    std::string open;
    do {
      if (!more()) return expected("a value");
      const char c = text_[at_];
      if (c == '(' || c == '[' || c == '{') {
        open += c == '(' ? ')' : c == '[' ? ']' : '}';
        if (open.size() > 1000) return refuse("Brackets are nested more than 1000 times.", "Export the file again.");
        ++at_;
      } else if (c == ')' || c == ']' || c == '}') {
        if (open.empty() || open.back() != c) return expected("a value");
        open.pop_back();
        ++at_;
      } else if (c == '"' || c == '\'') {
        if (!quoted(nullptr)) return false;
      } else if (c == '@') {
        if (!asset()) return false;
      } else if (c == '<') {
        if (!enclosed("<", ">")) return false;
      } else if (is_word(c) || is_number(c)) {
        while (at_ < text_.size() && (is_word(text_[at_]) || is_number(text_[at_]))) ++at_;
      } else if (!open.empty() && (c == ',' || c == '=')) {
        ++at_;
      } else {
        return expected("a value");
      }
    } while (!open.empty());
    return true;
  }

  /// Reads a value. `out` stays without value for None.
  bool value(std::optional<UsdValue>& out) {
    UsdValue read;
    std::string open;
    do {
      if (!more()) return expected("a value");
      const char c = text_[at_];
      if (c == '(' || c == '[') {
        open += c == '(' ? ')' : ']';
        if (open.size() > 8) return refuse("A value is nested more than 8 times.", "Export the file again.");
        ++at_;
      } else if (!open.empty() && c == open.back()) {
        open.pop_back();
        ++at_;
      } else if (c == ',' && !open.empty()) {
        ++at_;
      } else if (c == '"' || c == '\'') {
        if (!quoted(&read.texts.emplace_back())) return false;
      } else if (is_number(c) || is_word(c)) {
        const std::size_t from = at_;
        while (at_ < text_.size() && (is_word(text_[at_]) || is_number(text_[at_]))) ++at_;
        const std::string_view token = text_.substr(from, at_ - from);
        if (token == "None" && open.empty()) return true;
        const std::optional<double> number = formats::measured_number(token);
        if (!number) {
          const formats::NumberFault fault = formats::number_fault(token);
          problems_.add(fault.code, line_, fault.message, fault.remedy);
          return false;
        }
        read.numbers.push_back(*number);
      } else {
        return expected("a number or a text");
      }
    } while (!open.empty());
    out = std::move(read);
    return true;
  }

  bool samples(UsdAttribute& into) {
    into.samples.clear();
    if (!accept('{')) return expected("'{'");
    while (!accept('}')) {
      if (!more()) return expected("a time code");
      const std::size_t from = at_;
      while (at_ < text_.size() && (is_number(text_[at_]) || text_[at_] == 'e' || text_[at_] == 'E')) ++at_;
      const std::optional<double> time = formats::measured_number(text_.substr(from, at_ - from));
      if (!time) return refuse("A time code is not a number.", "Correct timeSamples.");
      if (!accept(':')) return expected("':'");
      std::optional<UsdValue> sample;
      if (!value(sample)) return false;
      if (sample) into.samples.emplace_back(*time, std::move(*sample));
      accept(',');
    }
    return true;
  }

  /// Reads metadata after "(" up to ")". @param prim -1: of the layer
  bool metadata(int prim) {
    constexpr std::array lists = {"prepend", "append", "add", "delete", "reorder"};
    constexpr std::array arcs = {"references", "payload", "inherits", "specializes", "subLayers", "clips"};
    while (!accept(')')) {
      if (next_is('"') || next_is('\'')) {  // a comment
        if (!quoted(nullptr)) return false;
        continue;
      }
      std::string_view key = word();
      const bool deleted = key == "delete";
      if (std::ranges::find(lists, key) != lists.end()) key = word();
      if (key.empty()) return expected("the name of a metadatum");
      if (!accept('=')) return expected("'='");
      if (std::ranges::find(arcs, key) != arcs.end() && !deleted) layer_.refers = true;
      if (key == "variants" && prim >= 0) {
        if (!selections(prim)) return false;
        continue;
      }
      const std::size_t from = at_;
      if (!skip()) return false;
      // a layer offset, or the path in a referenced file
      if (next_is('<') && !skip()) return false;
      if (next_is('(') && !skip()) return false;
      note(prim, key, text_.substr(from, at_ - from));
    }
    return true;
  }
  void note(int prim, std::string_view key, std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '"')) text.remove_prefix(1);
    while (!text.empty() && (static_cast<unsigned char>(text.back()) <= ' ' || text.back() == '"')) text.remove_suffix(1);
    if (prim >= 0) {
      if (key == "active") at(prim).active = text == "true" || text == "1";
    } else if (key == "upAxis") {
      layer_.up = text.empty() ? 'Y' : text.front();
    } else if (const std::optional<double> number = formats::measured_number(text); number && *number > 0) {
      if (key == "metersPerUnit") layer_.metres_per_unit = number;
      if (key == "timeCodesPerSecond") layer_.time_codes_per_second = number;
      if (key == "framesPerSecond") layer_.frames_per_second = number;
    }
  }
  /// variants = { string NAME = "VARIANT" ... }
  bool selections(int prim) {
    if (!accept('{')) return expected("'{'");
    while (!accept('}')) {
      word();
      std::string name(word()), chosen;
      if (name.empty() && (next_is('"') || next_is('\''))) {
        if (!quoted(&name)) return false;
      }
      if (!accept('=')) return expected("'='");
      if (!quoted(&chosen)) return false;
      variants_[{prim, name}] = chosen;
      accept(',');
    }
    return true;
  }

  UsdPrim& at(int prim) { return layer_.prims[static_cast<std::size_t>(prim)]; }

  /// Reads statements up to "}" (of the layer: to its end). @param weak true: in a variant; what the prim has is not replaced
  bool body(int prim, bool weak, int depth) {
    while (more() && !(prim >= 0 && text_[at_] == '}')) {
      const std::string_view first = word();
      bool good = true;
      if (first == "def" || first == "over" || first == "class")
        good = child(prim, first, weak, depth);
      else if (first == "variantSet")
        good = variant_set(prim, depth);
      else if (first == "reorder")
        good = !word().empty() && accept('=') ? skip() : expected("'='");
      else if (prim < 0 || first.empty())
        good = expected(prim < 0 ? "a prim" : "an attribute");
      else
        good = property(prim, first, weak);
      if (!good) return false;
    }
    return prim < 0 || accept('}') || expected("'}'");
  }

  bool child(int parent, std::string_view specifier, bool weak, int depth) {
    if (depth >= max_nesting) return refuse("Prims are nested more than 200 times.", "Export the file again.");
    const int line = line_;
    const std::string_view type = word();
    std::string name;
    if (!quoted(&name)) return false;
    if (name.empty() || name.contains('/')) return refuse("A prim has the name " + formats::in_quotes(name) + ".", "Correct the name.");
    std::string path = (parent < 0 ? "" : at(parent).path) + '/' + name;
    if (path.size() > 10'000) return refuse("A path has more than 10000 characters.", "Shorten the names of the prims.");
    const auto [found, is_new] = index_.try_emplace(path, static_cast<int>(layer_.prims.size()));
    const int own = found->second;
    if (is_new) {
      if (layer_.prims.size() >= max_prims) return refuse("The file has more than 200000 prims.", "Export the skeleton only.");
      UsdPrim& prim = layer_.prims.emplace_back();
      prim.name = name;
      prim.path = path;
      prim.parent = parent;
      prim.line = line;
    }
    if (!type.empty() && (at(own).type.empty() || !weak)) at(own).type = type;
    at(own).defined = at(own).defined || specifier == "def";
    if (accept('(') && !metadata(own)) return false;
    if (!accept('{')) return expected("'{'");
    return body(own, weak, depth + 1);
  }

  /// variantSet "NAME" = { "VARIANT" (metadata) { body } ... }: the body of the selected variant belongs to the prim.
  bool variant_set(int prim, int depth) {
    std::string set;
    if (prim < 0) return expected("a prim");
    if (depth >= max_nesting) return refuse("Variants are nested more than 200 times.", "Export the file again.");
    if (!quoted(&set) || !(accept('=') || expected("'='")) || !(accept('{') || expected("'{'"))) return false;
    while (!accept('}')) {
      std::string variant;
      if (!quoted(&variant)) return false;
      if (next_is('(') && !skip()) return false;
      const auto chosen = variants_.find({prim, set});
      if (chosen != variants_.end() && chosen->second == variant) {
        if (!accept('{')) return expected("'{'");
        if (!body(prim, true, depth + 1)) return false;
      } else if (!next_is('{') || !skip()) {
        return expected("'{'");
      }
    }
    return true;
  }

  bool property(int prim, std::string_view first, bool weak) {
    constexpr std::array modifiers = {"custom", "uniform", "varying", "config", "prepend", "append", "add", "delete"};
    bool deleted = false;
    while (std::ranges::find(modifiers, first) != modifiers.end()) {
      deleted = deleted || first == "delete";
      first = word();
    }
    const bool relation = first == "rel";
    if (!relation && accept('[') && !accept(']')) return expected("']'");
    std::string_view name = word();
    if (first.empty() || name.empty()) return expected("the name of an attribute");
    const int line = line_;
    std::string_view part;
    for (const std::string_view ending : {".timeSamples", ".connect", ".spline", ".default"})
      if (name.ends_with(ending)) {
        name.remove_suffix(ending.size());
        part = ending.substr(1);
      }
    if (accept('=')) {
      if (relation) {
        if (deleted ? !skip() : !targets(prim, name, weak)) return false;
      } else if (!is_wanted(name) || part == "connect" || part == "spline") {
        if (!skip()) return false;
      } else {
        UsdAttribute read;
        if (!(part == "timeSamples" ? samples(read) : value(read.value))) return false;
        UsdAttribute& kept = at(prim).attributes[std::string(name)];
        if (weak && (kept.value || !kept.samples.empty())) return true;
        kept.line = line;
        if (part == "timeSamples")
          kept.samples = std::move(read.samples);
        else
          kept.value = std::move(read.value);
      }
    }
    return !next_is('(') || skip();
  }

  bool targets(int prim, std::string_view name, bool weak) {
    std::string first;
    const bool list = accept('[');
    while (next_is('<')) {
      std::string path;
      if (!enclosed("<", ">", &path)) return false;
      if (first.empty()) first = absolute(path, at(prim).path);
      accept(',');
    }
    if (list ? !accept(']') : first.empty() && word() != "None") return expected("a path");
    if (!first.empty() && !(weak && at(prim).targets.contains(name))) at(prim).targets[std::string(name)] = first;
    return true;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  formats::Problems problems_;
  UsdLayer layer_;
  std::map<std::string, int, std::less<>> index_;                ///< prims by path
  std::map<std::pair<int, std::string>, std::string> variants_;  ///< selected variant by prim and set
};

}  // namespace

const UsdAttribute* UsdPrim::attribute(std::string_view wanted) const {
  const auto found = attributes.find(wanted);
  return found == attributes.end() ? nullptr : &found->second;
}

Result<UsdLayer> read_usda_layer(std::string_view text, std::string_view file_name) { return Parser(text, file_name).read(); }

}  // namespace ugoki::scene_formats
