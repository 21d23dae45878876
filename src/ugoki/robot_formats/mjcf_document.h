#pragma once
// MJCF files as trees of elements: includes in their place, default classes under the attributes. Internal to robot_formats.

#include <map>
#include <memory>
#include <optional>
#include <pugixml.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/robot_model.h"
#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

/// An element and the file in which it stands.
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

/// Every file that one reading opened: their problems and notes, and the bounds on their number and size.
class MjcfFiles {
 public:
  explicit MjcfFiles(const AssetReader& read) : read_(read) {}

  /// A parsed file, or null with a problem in it.
  [[nodiscard]] XmlFields* parse(std::string_view text, const std::string& file_name);
  /// The bytes of another file; the Error tells why not.
  [[nodiscard]] Result<std::string> read(const std::string& path) const;
  [[nodiscard]] bool failed() const;
  [[nodiscard]] bool full() const;
  /// At most twenty, each once.
  [[nodiscard]] Error take_problems();
  [[nodiscard]] std::vector<std::string> take_notes();

 private:
  const AssetReader& read_;
  std::vector<std::unique_ptr<XmlFields>> files_;
  std::size_t text_ = 0;
};

/// One model: a file and those that it includes, each once.
class MjcfDocument {
 public:
  /// @param folder of the model's file, "" or with a slash at its end; includes are relative to it
  [[nodiscard]] bool load(std::string_view text, const std::string& file_name, const std::string& folder, MjcfFiles& files);
  [[nodiscard]] MjcfElement root() const { return root_; }
  /// Child elements; those of an included file stand in the place of its <include>.
  [[nodiscard]] std::vector<MjcfElement> children(const MjcfElement& parent) const;
  /// Children of the root of one kind ("worldbody"), in order; MJCF allows several.
  [[nodiscard]] std::vector<MjcfElement> sections(std::string_view kind) const;

 private:
  bool load_includes(const MjcfElement& from, const std::string& folder, MjcfFiles& files);
  void append_children(const MjcfElement& parent, std::vector<MjcfElement>& out) const;

  MjcfElement root_;
  std::map<const pugi::xml_node_struct*, MjcfElement> included_;  ///< <include> -> root of the file
  std::vector<std::string> paths_;                                ///< included so far
};

/// The attributes of an element over those of its default class, that class's parent, and so on; nearest first.
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
  /// Place of the attribute's word among `words`; `fallback` where it is absent or, with a problem, none of them.
  [[nodiscard]] int keyword(const char* name, std::initializer_list<std::string_view> words, int fallback) const;
  /// Two numbers, infinite from +-1e9 on. False (out unchanged) where absent or wrong.
  bool range(const char* name, std::span<double, 2> out) const;
  bool numbers(const char* name, std::span<double> out, Bounds bounds = {}) const;
  /// Attributes that may give fewer numbers than there are: each level overwrites as many as it gives.
  /// @return how many of `out` were given by some level
  std::size_t overlay(const char* name, std::span<double> out, Bounds bounds = {}) const;

 private:
  [[nodiscard]] const MjcfElement* level_of(const char* name) const;
  std::vector<MjcfElement> levels_;
};

/// Default classes of one model.
class MjcfDefaults {
 public:
  void read(const MjcfDocument& document);
  [[nodiscard]] bool knows(const std::string& class_name) const { return classes_.contains(class_name); }
  /// The element with its class: its own `class`, otherwise `childclass`, otherwise "main".
  /// @param family of the defaults, where the element's kind does not tell (<joint> in <equality>)
  [[nodiscard]] MjcfAttributes attributes(const MjcfElement& element, const std::string& childclass, std::string_view family = {}) const;

 private:
  struct Class {
    std::string parent;
    std::map<std::string, std::vector<MjcfElement>, std::less<>> elements;  ///< by family; the last one is nearest
  };
  void read_class(const MjcfDocument& document, const MjcfElement& element, const std::string& parent, int depth);
  std::map<std::string, Class, std::less<>> classes_;
};

}  // namespace ugoki::robot_formats
