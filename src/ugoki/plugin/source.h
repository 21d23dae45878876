#pragma once
// Reader of C and C++ files for the LSI builder: finds the functions that can become LSIs, the structs of their states, and the annotations
// in comments. It reads declarations only and does not expand macros. It marks types that it does not know; make_wrapper reports them.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki::plugin {

/// One annotation of a comment: "@in x: vector [m] = 1, -5..5 How far."
struct Annotation {
  std::string word;                  ///< keyword without the '@' (or '\') before it: "in"
  std::string name;                  ///< name of the parameter of the C function, or of the field
  std::string type;                  ///< pin type, "vector"; empty: follows from the C type
  std::string unit, doc;             ///< unit and description: "m", "How far."
  std::vector<std::string> choices;  ///< values of a choice parameter: {linear, cubic}
  bool has_value = false, has_range = false;
  double value = 0, minimum = 0, maximum = 0;
  std::string word_value;  ///< initial value that is a word: true, false, or a word of `choices`
  int line = 0;            ///< line number in the file, from 1
};

/// The comment before a function, with its annotations.
struct Comment {
  std::string doc;  ///< text of the comment outside of annotations
  std::vector<Annotation> annotations;
  /// The first annotation with the keyword `word` and, unless `name` is empty, with the name `name`; null: none.
  [[nodiscard]] const Annotation* find(std::string_view word, std::string_view name = {}) const;
};

/// The type of a variable or function result, possibly one that the builder does not know.
struct CType {
  std::string base;  ///< "double", "int", "struct spring"; empty: unknown
  std::string text;  ///< the type as written in the file, for messages
  bool is_const = false;
  int pointers = 0;  ///< number of '*', '&' and '[]'
  bool reference = false;
  int elements = 0;                    ///< number of elements of an array; 0: not an array
  [[nodiscard]] bool numeric() const;  ///< true if `base` is an arithmetic type of C
  [[nodiscard]] bool by_value() const { return pointers == 0 && elements == 0; }
};

/// A parameter of a function, or a field of a struct.
struct CVariable {
  CType type;
  std::string name;
  std::string initial;  ///< initial value of a member: "3"
  std::string comment;  ///< text of the comment after the declaration, on the same line
  int line = 0;
};

/// A function with a body in a source file.
struct CFunction {
  std::string name;  ///< name with its namespaces: "signals::smooth"
  CType result;
  std::vector<CVariable> parameters;
  Comment comment;
  int line = 0;
  bool is_static = false;
};

/// A struct (or a class in C++) in a source file.
struct CStruct {
  std::string name;   ///< name as written in a parameter: "struct spring" or "spring"
  std::string alias;  ///< another spelling (typedef name, or the tag in C++); may be empty
  std::string full;   ///< name with its namespaces, for code outside of them
  std::vector<CVariable> fields;
  bool understood = true;  ///< true: every field is a number or an array of numbers
  int line = 0;
};

/// Functions, structs and first comment of a source file.
struct CSource {
  std::vector<CFunction> functions;
  std::vector<CStruct> structs;
  Comment file;                   ///< the first comment of the file; describes the library if it has @library
  bool declares_library = false;  ///< the file uses UGOKI_LIBRARY or ugoki_lsi_library, so it needs no wrapper
  bool declares_lsis = false;     ///< true: the file uses UGOKI_LSI
  [[nodiscard]] const CStruct* find_struct(std::string_view name) const;      ///< finds a struct by name or alias; null: none
  [[nodiscard]] const CFunction* find_function(std::string_view name) const;  ///< finds a function by its name with namespaces; null: none
};

/// Reads a file. Accepts any text: parts that are not valid C or C++ are skipped. @param cpp the language is C++
[[nodiscard]] CSource read_source(std::string_view text, bool cpp);

}  // namespace ugoki::plugin
