#pragma once
// Reading of XML elements and attributes with the line that each stands on; internal to robot_formats.
//
// Hostile input: no entities of its own, no other files, at most `max_text` bytes, `max_levels` levels and
// `max_attributes` attributes an element; a name twice in one element is refused. Numbers are finite. All problems
// go into one bounded list; a field that is wrong keeps its default, so that reading goes on and finds more.

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

inline constexpr std::size_t max_text = std::size_t{1} << 28;
inline constexpr int max_levels = 2'000;
inline constexpr int max_attributes = 200;

/// The text of an attribute or of an element. Where it stands and what it is called is worked out only for a problem.
struct XmlField {
  std::string_view text = {};  ///< without blanks at its ends
  bool present = false;
  pugi::xml_node node = {};            ///< the element that has it
  pugi::xml_attribute attribute = {};  ///< where it is one
  const char* name = "";               ///< of the attribute or of the element inside `node`; empty: the node's own text
};

/// Bounds of a number, both allowed.
struct Bounds {
  double low = -formats::max_magnitude, high = formats::max_magnitude;
};
inline constexpr Bounds not_negative{0, formats::max_magnitude};

class XmlFields {
 public:
  /// @param format for messages: "URDF"
  XmlFields(std::string_view file_name, std::string_view format);

  /// Takes a copy of the text. False: the problems tell why. Once an object.
  [[nodiscard]] bool parse(std::string_view text);
  /// The one outermost element.
  [[nodiscard]] pugi::xml_node root() const { return document_.document_element(); }

  [[nodiscard]] int line(pugi::xml_node node) const;
  [[nodiscard]] int line(pugi::xml_attribute attribute) const;
  [[nodiscard]] int line(const XmlField& field) const;
  /// "arm.urdf:17"
  [[nodiscard]] std::string place(pugi::xml_node node) const;
  /// "<joint> 'left_knee'": its element and, if it has one, its name.
  [[nodiscard]] std::string title(pugi::xml_node node) const;

  /// "'mass' of <inertial>": for messages.
  [[nodiscard]] std::string what(const XmlField& field) const;

  void problem(int line, ErrorCode code, std::string message, std::string remedy);
  void problem(pugi::xml_node node, ErrorCode code, std::string message, std::string remedy);
  /// The message begins with what the field is: "'mass' of <inertial>" + message.
  void problem(const XmlField& field, ErrorCode code, const std::string& message, std::string remedy);
  /// So many problems that looking for more is of no use.
  [[nodiscard]] bool full() const { return problems_.full(); }
  [[nodiscard]] bool failed() const { return !problems_.empty(); }
  [[nodiscard]] Error take_problems() { return problems_.take(); }

  /// A sentence for people. Equal sentences become one, with the lines on which they hold.
  void note(pugi::xml_node node, std::string sentence);
  void note(std::string sentence);
  /// "sentence (a.urdf:12, 40, 66 and 9 more)", in the order in which each was first made.
  [[nodiscard]] std::vector<std::string> take_notes();
  /// Notes the children whose element is none of `known`, once for each element name.
  void note_unread(pugi::xml_node node, std::initializer_list<std::string_view> known);

  [[nodiscard]] XmlField attribute(pugi::xml_node node, const char* name) const;
  /// The text inside the first child element `name`.
  [[nodiscard]] XmlField element(pugi::xml_node node, const char* name) const;
  /// The text inside the node itself.
  [[nodiscard]] XmlField content(pugi::xml_node node) const;

  /// Valid UTF-8; empty where the field is absent.
  [[nodiscard]] std::string text(const XmlField& field) const;
  /// The same, and a problem where it is absent or empty.
  [[nodiscard]] std::string required_text(const XmlField& field);
  /// `fallback` where the field is absent; a problem (and `fallback`) where it is no number within the bounds.
  [[nodiscard]] double number(const XmlField& field, double fallback, Bounds bounds = {});
  /// A limit: any finite number or inf; from +-1e9 on it is none, that is +-infinity.
  [[nodiscard]] double limit(const XmlField& field, double fallback);
  [[nodiscard]] int integer(const XmlField& field, int fallback, int low, int high);
  /// true, false, 1, 0.
  [[nodiscard]] bool flag(const XmlField& field, bool fallback);
  /// Exactly out.size() numbers. False (out unchanged) where the field is absent or, with a problem, wrong.
  bool numbers(const XmlField& field, std::span<double> out, Bounds bounds = {});
  /// At most `most` numbers; empty where absent or, with a problem, wrong.
  [[nodiscard]] std::vector<double> list(const XmlField& field, std::size_t least, std::size_t most, Bounds bounds = {});
  [[nodiscard]] Vec3 vec3(const XmlField& field, const Vec3& fallback, Bounds bounds = {});
  /// Made unit; a problem where it has no direction.
  [[nodiscard]] Vec3 direction(const XmlField& field, const Vec3& fallback);

 private:
  [[nodiscard]] int line_at(const char* in_buffer) const;
  [[nodiscard]] std::optional<double> one_number(const XmlField& field, std::string_view token, Bounds bounds);
  bool check_tree();

  struct Note {
    std::string sentence;
    std::vector<int> lines;  ///< the first few
    std::size_t count = 0;
  };
  std::string file_, format_;
  std::string buffer_;                    ///< parsed in place: every name and text points into it
  std::vector<std::size_t> line_starts_;  ///< offsets in the text as it was
  pugi::xml_document document_;
  formats::Problems problems_;
  std::vector<Note> notes_;
  std::map<std::string, std::size_t, std::less<>> note_index_;
};

}  // namespace ugoki::robot_formats
