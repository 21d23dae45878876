#pragma once
// Reads XML elements and attributes, and reports problems with line numbers. Used by robot_formats and by the
// reader of MVNX in scene_formats.
//
// Safe for hostile input: no user-defined entities, no external files, at most `max_text` bytes, `max_levels` levels and `max_attributes`
// attributes in an element. Duplicate attributes are refused. Numbers must be finite. All problems are collected in one bounded list. For
// an invalid field its default value is returned, so that reading continues and finds more problems.

#include <cstddef>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/text.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::robot_formats {

inline constexpr std::size_t max_text = std::size_t{1} << 28;  // bytes, 256 MB
inline constexpr int max_levels = 2'000;
inline constexpr int max_attributes = 200;

/// The text of an attribute or element. Line number and name are computed only when a problem is reported.
struct XmlField {
  std::string_view text = {};  ///< without leading and trailing white space
  bool present = false;
  pugi::xml_node node = {};            ///< the element that has the attribute, or that contains the child element
  pugi::xml_attribute attribute = {};  ///< empty if the field is an element
  const char* name = "";               ///< name of the attribute or child element; empty: the text of `node` itself
};

/// Range of allowed numbers, bounds included.
struct Bounds {
  double low = -formats::max_magnitude, high = formats::max_magnitude;
};
inline constexpr Bounds not_negative{0, formats::max_magnitude};

/// A parsed XML file with its problems and notes. Not copyable, because names and texts are views into the parsed buffer.
class XmlFields {
 public:
  /// @param format name of the format in messages, for example "URDF"
  XmlFields(std::string_view file_name, std::string_view format);

  /// Copies and parses the text. Returns false if it is refused; see take_problems(). Call it at most once.
  [[nodiscard]] bool parse(std::string_view text);
  /// Returns the outermost element.
  [[nodiscard]] pugi::xml_node root() const { return document_.document_element(); }

  [[nodiscard]] int line(pugi::xml_node node) const;
  [[nodiscard]] int line(pugi::xml_attribute attribute) const;
  [[nodiscard]] int line(const XmlField& field) const;
  /// Returns the location of an element, for messages: "arm.urdf:17".
  [[nodiscard]] std::string location(pugi::xml_node node) const;
  /// Returns element and name, for messages: "<joint> 'left_knee'", or "<joint>" if it has no name.
  [[nodiscard]] std::string title(pugi::xml_node node) const;

  /// Returns a description of a field, for messages: "'mass' of <inertial>".
  [[nodiscard]] std::string describe(const XmlField& field) const;

  void problem(int line, ErrorCode code, std::string message, std::string remedy);
  void problem(pugi::xml_node node, ErrorCode code, std::string message, std::string remedy);
  /// Adds a problem. Its message is describe(field) + `message`, so `message` begins with a blank or colon.
  void problem(const XmlField& field, ErrorCode code, const std::string& message, std::string remedy);
  /// True if the list of problems is full, so that further reading is useless.
  [[nodiscard]] bool full() const { return problems_.full(); }
  [[nodiscard]] bool failed() const { return !problems_.empty(); }
  [[nodiscard]] Error take_problems() { return problems_.take(); }

  /// Adds a sentence for the user. Equal sentences become one note with all line numbers.
  void note(pugi::xml_node node, std::string sentence);
  void note(std::string sentence);
  /// Returns the notes in the order of their first occurrence: "sentence (a.urdf:12, 40, 66 and 9 more)".
  [[nodiscard]] std::vector<std::string> take_notes();
  /// Adds a note for each kind of child element whose name is not in `known`.
  void note_unread(pugi::xml_node node, std::initializer_list<std::string_view> known);

  [[nodiscard]] XmlField attribute(pugi::xml_node node, const char* name) const;
  /// Returns the text of the first child element called `name`.
  [[nodiscard]] XmlField element(pugi::xml_node node, const char* name) const;
  /// Returns the text of the node itself.
  [[nodiscard]] XmlField content(pugi::xml_node node) const;

  /// Returns the text as valid UTF-8; empty if the field is absent.
  [[nodiscard]] std::string text(const XmlField& field) const;
  /// The same as text(), but adds a problem if the field is absent or empty.
  [[nodiscard]] std::string required_text(const XmlField& field);
  /// Returns the number; `fallback` if the field is absent or, with a problem, if it is not a number within the bounds.
  [[nodiscard]] double number(const XmlField& field, double fallback, Bounds bounds = {});
  /// Returns a joint limit: any finite number, inf or -inf; magnitudes of 1e9 or more become +-infinity. `fallback` as in number().
  [[nodiscard]] double limit(const XmlField& field, double fallback);
  /// Returns an integer from `low` to `high`; `fallback` as in number().
  [[nodiscard]] int integer(const XmlField& field, int fallback, int low, int high);
  /// Returns true for "true" and "1", false for "false" and "0"; `fallback` as in number().
  [[nodiscard]] bool flag(const XmlField& field, bool fallback);
  /// Reads exactly out.size() numbers. If the field is absent or invalid, returns false and does not change `out`; an invalid field also
  /// adds a problem.
  bool numbers(const XmlField& field, std::span<double> out, Bounds bounds = {});
  /// Reads from `minimum` to `maximum` numbers. Returns an empty list if the field is absent or invalid; an invalid field adds a problem.
  [[nodiscard]] std::vector<double> list(const XmlField& field, std::size_t minimum, std::size_t maximum, Bounds bounds = {});
  [[nodiscard]] Vec3 vec3(const XmlField& field, const Vec3& fallback, Bounds bounds = {});
  /// Returns a vector scaled to unit length. If its length is below 1e-9, returns `fallback` and adds a problem.
  [[nodiscard]] Vec3 direction(const XmlField& field, const Vec3& fallback);

 private:
  [[nodiscard]] int line_at(const char* in_buffer) const;
  [[nodiscard]] std::optional<double> one_number(const XmlField& field, std::string_view token, Bounds bounds);
  bool check_tree();

  struct Note {
    std::string sentence;
    std::vector<int> lines;  ///< line numbers of the first few occurrences
    std::size_t count = 0;   ///< number of occurrences
  };
  std::string file_, format_;
  std::string buffer_;                    ///< parsed in place; all names and texts are views into it
  std::vector<std::size_t> line_starts_;  ///< offset of each line in the original text
  pugi::xml_document document_;
  formats::Problems problems_;
  std::vector<Note> notes_;
  std::map<std::string, std::size_t, std::less<>> note_index_;
};

}  // namespace ugoki::robot_formats
