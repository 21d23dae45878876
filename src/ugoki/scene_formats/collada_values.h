#pragma once
// <source> elements of a COLLADA document: arrays of numbers or names, and how accessors divide them into values. Internal to
// scene_formats.

#include <map>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// Returns the words, separated by white space, of the first text inside a node.
[[nodiscard]] std::vector<std::string_view> words_in(pugi::xml_node node);
/// Returns the id in an attribute "#id"; empty if the attribute is absent or refers to another file.
[[nodiscard]] std::string_view local_id(pugi::xml_node node, const char* attribute);

/// The values of a source: `count` values of `size` words each. Value i begins at words[offset + i * stride]. The words are views into the
/// document.
struct ColladaValues {
  std::vector<std::string_view> words;
  std::size_t count = 0, offset = 0, stride = 1;
  std::size_t size = 1;  ///< words in a value; for example 16 for a matrix
  bool text = false;     ///< the words are names, not numbers
  [[nodiscard]] std::string_view word(std::size_t value, std::size_t part) const { return words[offset + value * stride + part]; }
};

/// A parsed COLLADA document.
class ColladaDocument {
 public:
  explicit ColladaDocument(std::string_view location) : location_(location) {}
  /// Parses the document. Errors: not XML, not COLLADA, nested too deeply.
  [[nodiscard]] Result<void> load(const char* bytes, std::size_t size);
  [[nodiscard]] pugi::xml_node root() { return document_.child("COLLADA"); }
  [[nodiscard]] const pugi::xml_document& document() const { return document_; }

  /// Returns an Error whose location is the line of `node`.
  [[nodiscard]] std::unexpected<Error> refuse(pugi::xml_node node, ErrorCode code, std::string message) const;
  /// Returns the values of the source that an <input> refers to. Errors: the source does not exist, or its accessor exceeds its array.
  [[nodiscard]] Result<ColladaValues> values_of(pugi::xml_node input) const;
  /// Converts `word`, found in `node`, to a finite number; an Error if it is not a number.
  [[nodiscard]] Result<double> number(pugi::xml_node node, std::string_view word) const;
  /// Returns an integer attribute from 0 to 1e9; `missing` if the attribute is absent.
  [[nodiscard]] Result<std::size_t> count_of(pugi::xml_node node, const char* attribute, std::size_t missing) const;

 private:
  std::string location_;
  std::string text_;  ///< the document's text, for computing line numbers
  pugi::xml_document document_;
  std::map<std::string, pugi::xml_node, std::less<>> sources_, arrays_;  ///< by id
};

}  // namespace ugoki::scene_formats
