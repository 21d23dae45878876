#include "ugoki/scene_formats/collada_values.h"

#include <algorithm>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"

namespace ugoki::scene_formats {
namespace {

constexpr const char* remedy = "Export it again, or as glTF or BVH.";

}  // namespace

std::vector<std::string_view> words_in(pugi::xml_node node) {
  std::vector<std::string_view> out;
  const std::string_view text = node.text().get();
  constexpr std::string_view blanks = " \t\r\n";
  for (std::size_t at = text.find_first_not_of(blanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(blanks, at), text.size());
    out.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(blanks, end);
  }
  return out;
}

std::string_view local_id(pugi::xml_node node, const char* attribute) {
  const std::string_view url = node.attribute(attribute).value();
  return url.starts_with('#') ? url.substr(1) : std::string_view();
}

Result<void> ColladaDocument::load(const char* bytes, std::size_t size) {
  const pugi::xml_parse_result parsed = document_.load_buffer(bytes, size);
  text_.assign(bytes, size);
  if (!parsed)
    return fail(
        ErrorCode::syntax,
        location_ + ", line " +
            std::to_string(1 + std::count(text_.begin(), text_.begin() + std::min<std::ptrdiff_t>(parsed.offset, std::ssize(text_)), '\n')),
        "The file cannot be read as COLLADA: " + std::string(parsed.description()) + ".", remedy);
  if (!root()) return fail(ErrorCode::syntax, location_, "The file cannot be read as COLLADA: it has no <COLLADA> element.", remedy);
  struct Walker final : pugi::xml_tree_walker {
    ColladaDocument* all = nullptr;
    bool for_each(pugi::xml_node& node) override {
      const std::string_view name = node.name(), id = node.attribute("id").value();
      if (name == "source") all->sources_.emplace(id, node);
      if (name == "float_array" || name == "Name_array" || name == "IDREF_array") all->arrays_.emplace(id, node);
      return depth() < static_cast<int>(formats::max_depth);
    }
  } walker;
  walker.all = this;
  if (!document_.traverse(walker))
    return fail(ErrorCode::range, location_, "The elements are nested deeper than " + std::to_string(formats::max_depth) + " levels.",
                remedy);
  return {};
}

std::unexpected<Error> ColladaDocument::refuse(pugi::xml_node node, ErrorCode code, std::string message) const {
  const std::ptrdiff_t at = std::clamp<std::ptrdiff_t>(node.offset_debug(), 0, std::ssize(text_));
  std::string location =
      location_ + ", line " + std::to_string(1 + std::count(text_.begin(), text_.begin() + at, '\n')) + ", <" + node.name() + ">";
  return fail(code, std::move(location), std::move(message), remedy);
}

Result<double> ColladaDocument::number(pugi::xml_node node, std::string_view word) const {
  const std::optional<double> x = formats::measured_number(word);
  if (!x) return refuse(node, ErrorCode::syntax, formats::in_quotes(word) + " is not a valid number.");
  return *x;
}

Result<std::size_t> ColladaDocument::count_of(pugi::xml_node node, const char* attribute, std::size_t missing) const {
  const std::string_view text = node.attribute(attribute).value();
  if (text.empty()) return missing;
  const std::optional<long> x = parse_long(text);
  if (!x || *x < 0 || *x > 1'000'000'000)
    return refuse(
        node, ErrorCode::range,
        "The attribute '" + std::string(attribute) + "' is " + formats::in_quotes(text) + ", not an integer from 0 to 1000000000.");
  return static_cast<std::size_t>(*x);
}

Result<ColladaValues> ColladaDocument::values_of(pugi::xml_node input) const {
  const auto source = sources_.find(local_id(input, "source"));
  if (source == sources_.end())
    return refuse(input, ErrorCode::structure,
                  "The <input> refers to the source " + formats::in_quotes(input.attribute("source").value()) + ", which does not exist.");
  const pugi::xml_node accessor = source->second.child("technique_common").child("accessor");
  const auto array = arrays_.find(local_id(accessor, "source"));
  if (!accessor || array == arrays_.end())
    return refuse(source->second, ErrorCode::structure, "The accessor of the source does not refer to an array of numbers or names.");
  ColladaValues out;
  out.text = std::string_view(array->second.name()) != "float_array";
  out.words = words_in(array->second);
  const Result<std::size_t> declared = count_of(array->second, "count", out.words.size()), count = count_of(accessor, "count", 0),
                            offset = count_of(accessor, "offset", 0), stride = count_of(accessor, "stride", 1);
  for (const Result<std::size_t>* x : {&declared, &count, &offset, &stride})
    if (!*x) return fail(x->error());
  if (*declared > out.words.size())
    return refuse(array->second, ErrorCode::truncated,
                  "The array declares " + std::to_string(*declared) + " values, but has " + std::to_string(out.words.size()) + ".");
  out.words.resize(*declared);
  out.count = *count;
  out.offset = *offset;
  out.stride = *stride;
  out.size = 0;
  for (const pugi::xml_node param : accessor.children("param"))
    if (param.attribute("type")) out.size += std::string_view(param.attribute("type").value()) == "float4x4" ? 16 : 1;
  out.size = std::max<std::size_t>(out.size, 1);
  if (out.count > 0 && out.offset + (out.count - 1) * out.stride + out.size > out.words.size())
    return refuse(
        accessor, ErrorCode::truncated,
        "The " + std::to_string(out.count) + " values of the accessor exceed its array of " + std::to_string(out.words.size()) + " words.");
  return out;
}

}  // namespace ugoki::scene_formats
