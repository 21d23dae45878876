#pragma once
// MJCF files as trees of XML elements. Includes are replaced by their contents; default classes supply missing attributes.
// Internal to robot_formats.

#include <map>
#include <memory>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/robot_model.h"
#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

/// An XML element together with the file that contains it.
struct MjcfElement {
  pugi::xml_node node = {};
  XmlFields* file = nullptr;

  explicit operator bool() const { return static_cast<bool>(node); }
  [[nodiscard]] std::string_view kind() const { return node.name(); }
  [[nodiscard]] XmlField attribute(const char* name) const { return file->attribute(node, name); }
  [[nodiscard]] std::string text(const char* name) const { return file->text(attribute(name)); }
  [[nodiscard]] bool has(const char* name) const { return static_cast<bool>(node.attribute(name)); }
  [[nodiscard]] std::string title() const { return file->title(node); }
  void problem(ErrorCode code, const std::string& message, const std::string& remedy) const { file->problem(node, code, message, remedy); }
  void note(const std::string& sentence) const { file->note(node, sentence); }
};

/// All files opened while one model is read: their problems and notes, and limits on their number and total size.
class MjcfFiles {
 public:
  explicit MjcfFiles(const AssetReader& read) : read_(read) {}

  /// Parses a file. Returns null and records a problem if parsing fails. This object owns the result.
  [[nodiscard]] XmlFields* parse(std::string_view text, const std::string& file_name);
  /// Returns the bytes of another file, or the Error of the reader function.
  [[nodiscard]] Result<std::string> read(const std::string& path) const;
  [[nodiscard]] bool failed() const;
  [[nodiscard]] bool full() const;
  /// At most 20 problems, without duplicates.
  [[nodiscard]] Error take_problems();
  [[nodiscard]] std::vector<std::string> take_notes();

 private:
  const AssetReader& read_;
  std::vector<std::unique_ptr<XmlFields>> files_;
  std::size_t text_ = 0;
};

/// One model: its file and all files that it includes. Each file may be included once.
class MjcfDocument {
 public:
  /// @param folder folder of the model's file: "", or ending with a slash; includes are relative to it
  [[nodiscard]] bool load(std::string_view text, const std::string& file_name, const std::string& folder, MjcfFiles& files);
  [[nodiscard]] MjcfElement root() const { return root_; }
  /// Returns the child elements. An <include> is replaced by the children of the included file's root.
  [[nodiscard]] std::vector<MjcfElement> children(const MjcfElement& parent) const;
  /// Returns the children of the root with this element name ("worldbody"), in file order; MJCF allows several.
  [[nodiscard]] std::vector<MjcfElement> sections(std::string_view kind) const;

 private:
  bool load_includes(const MjcfElement& from, const std::string& folder, MjcfFiles& files);
  void append_children(const MjcfElement& parent, std::vector<MjcfElement>& out) const;

  MjcfElement root_;
  std::map<const pugi::xml_node_struct*, MjcfElement> included_;  ///< <include> -> root of the included file
  std::vector<std::string> paths_;                                ///< paths of the files read so far
};

/// The attributes of an element and of its default classes, in levels: the element itself, its default class, the parent of this class, and
/// so on. The value of an attribute is taken from the first level that contains it.
class MjcfAttributes {
 public:
  explicit MjcfAttributes(MjcfElement own) : levels_{own} {}
  void add_level(MjcfElement level) { levels_.push_back(level); }
  [[nodiscard]] const MjcfElement& own() const { return levels_.front(); }
  [[nodiscard]] std::span<const MjcfElement> levels() const { return levels_; }

  [[nodiscard]] bool has(const char* name) const { return level_of(name) != nullptr; }
  [[nodiscard]] std::string text(const char* name) const;
  [[nodiscard]] double number(const char* name, double fallback, Bounds bounds = {}) const;
  [[nodiscard]] int integer(const char* name, int fallback, int low, int high) const;
  [[nodiscard]] bool flag(const char* name, bool fallback) const;
  [[nodiscard]] Vec3 vec3(const char* name, const Vec3& fallback) const;
  /// Returns the index of the attribute's value in `words`; `fallback` if it is absent or, with a problem, if it has another value.
  [[nodiscard]] int keyword(const char* name, std::initializer_list<std::string_view> words, int fallback) const;
  /// Reads two numbers; a magnitude of 1e9 or more means infinite. If the attribute is absent or invalid, returns false and does not change
  /// `out`; an invalid attribute also adds a problem.
  bool range(const char* name, std::span<double, 2> out) const;
  bool numbers(const char* name, std::span<double> out, Bounds bounds = {}) const;
  /// Reads an attribute that may have fewer numbers than `out`. Each level, starting with the most general class, overwrites as many
  /// numbers as it contains.
  /// @return the maximum number of values in a level; the rest of `out` is unchanged
  std::size_t overlay(const char* name, std::span<double> out, Bounds bounds = {}) const;

 private:
  [[nodiscard]] const MjcfElement* level_of(const char* name) const;
  std::vector<MjcfElement> levels_;
};

/// The default classes of one model. The outermost class is always "main". If the file gives it another name, both names are valid.
class MjcfDefaults {
 public:
  void read(const MjcfDocument& document);
  [[nodiscard]] bool knows(const std::string& class_name) const { return classes_.contains(class_name); }
  /// Returns the attributes of an element. Its default class is named by its attribute `class`, else by `childclass`, else it is "main".
  /// @param family set of defaults to use, if the element name does not determine it (<joint> inside <equality>)
  [[nodiscard]] MjcfAttributes attributes(const MjcfElement& element, const std::string& childclass, std::string_view family = {}) const;

 private:
  struct Class {
    std::string parent;
    std::map<std::string, std::vector<MjcfElement>, std::less<>> elements;  ///< by family of elements (family_of); later elements override
                                                                            ///< earlier ones
  };
  void read_class(const MjcfDocument& document, const MjcfElement& element, const std::string& parent, int depth);
  std::map<std::string, Class, std::less<>> classes_;
  std::set<std::string> outermost_names_;  ///< second names of the class "main"; each outermost <default> can give one
};

}  // namespace ugoki::robot_formats
