#pragma once
// Sources of a COLLADA document: arrays of numbers or names, and how they are cut into values. Internal to scene_formats.

#include <map>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// The words of the first text inside a node.
[[nodiscard]] std::vector<std::string_view> words_in(pugi::xml_node node);
/// The id in "#id"; empty: none.
[[nodiscard]] std::string_view local_id(pugi::xml_node node, const char* attribute);

/// `count` values of `size` words each.
struct ColladaValues {
  std::vector<std::string_view> words;
  std::size_t count = 0, offset = 0, stride = 1;
  std::size_t size = 1;  ///< numbers in a value; a matrix counts 16
  bool text = false;     ///< names, not numbers
  [[nodiscard]] std::string_view word(std::size_t value, std::size_t part) const { return words[offset + value * stride + part]; }
};

class ColladaDocument {
 public:
  explicit ColladaDocument(std::string_view place) : place_(place) {}
  /// Reads the document; refuses what is no XML, no COLLADA, or nested too deeply.
  [[nodiscard]] Result<void> load(const char* bytes, std::size_t size);
  [[nodiscard]] pugi::xml_node root() { return document_.child("COLLADA"); }
  [[nodiscard]] const pugi::xml_document& document() const { return document_; }

  /// A problem at the line of `node`.
  [[nodiscard]] std::unexpected<Error> refuse(pugi::xml_node node, ErrorCode code, std::string message) const;
  /// The source of an <input>: it exists, and its values lie within its array.
  [[nodiscard]] Result<ColladaValues> values_of(pugi::xml_node input) const;
  /// The number of a word of `node`.
  [[nodiscard]] Result<double> number(pugi::xml_node node, std::string_view word) const;
  /// A whole number that an attribute tells, at most a billion; `missing` without the attribute.
  [[nodiscard]] Result<std::size_t> count_of(pugi::xml_node node, const char* attribute, std::size_t missing) const;

 private:
  std::string place_;
  std::string text_;  ///< for lines
  pugi::xml_document document_;
  std::map<std::string, pugi::xml_node, std::less<>> sources_, arrays_;
};

}  // namespace ugoki::scene_formats
