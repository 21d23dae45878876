#pragma once
// What a C or C++ file offers to become LSIs: its functions, and the structs that hold their state. A reader of declarations, no
// compiler: what it does not understand it leaves alone and says so.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki::plugin {

/// "@in x: vector [m] = 1, -5..5 How far." of a comment.
struct Annotation {
  std::string word;  ///< "in", without the sign
  std::string name;
  std::string type;  ///< "vector"; empty: by its C type
  std::string unit, doc;
  std::vector<std::string> choices;  ///< {linear, cubic}
  bool has_value = false, has_range = false;
  double value = 0, minimum = 0, maximum = 0;
  std::string word_value;  ///< of a choice
  int line = 0;
};

struct Comment {
  std::string doc;
  std::vector<Annotation> annotations;
  [[nodiscard]] const Annotation* find(std::string_view word, std::string_view name = {}) const;
};

/// A type that the builder knows, or not.
struct CType {
  std::string base;  ///< "double", "int", "struct spring"; empty: not understood
  std::string text;  ///< as written, for messages
  bool is_const = false;
  int pointers = 0;  ///< stars; a reference counts as one
  bool reference = false;
  int elements = 0;                    ///< of an array; 0: none
  [[nodiscard]] bool numeric() const;  ///< base is a number of C
  [[nodiscard]] bool by_value() const { return pointers == 0 && elements == 0; }
};

struct CVariable {
  CType type;
  std::string name;
  std::string initial;  ///< "= 3" of a member, without the sign
  std::string comment;  ///< behind it on the line
  int line = 0;
};

struct CFunction {
  std::string name;  ///< with its namespaces
  CType result;
  std::vector<CVariable> parameters;
  Comment comment;
  int line = 0;
  bool is_static = false;
};

struct CStruct {
  std::string name;   ///< as it is written in a parameter: "struct spring" or "spring"
  std::string alias;  ///< the other way to write it; may be empty
  std::string full;   ///< as it is written outside of its namespaces
  std::vector<CVariable> fields;
  bool understood = true;  ///< every field is a number or an array of numbers
  int line = 0;
};

struct CSource {
  std::vector<CFunction> functions;
  std::vector<CStruct> structs;
  Comment file;                   ///< the first comment, if it says @library
  bool declares_library = false;  ///< it has UGOKI_LIBRARY or ugoki_lsi_library itself
  bool declares_lsis = false;     ///< it has UGOKI_LSI
  [[nodiscard]] const CStruct* find_struct(std::string_view name) const;
  [[nodiscard]] const CFunction* find_function(std::string_view name) const;
};

[[nodiscard]] CSource read_source(std::string_view text, bool cpp);

}  // namespace ugoki::plugin
