#include "ugoki/plugin/wrapper.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>

#include "ugoki/base/number.h"
#include "ugoki/plugin/comment.h"

namespace ugoki::plugin {
namespace {

/// Returns `text` as a C string literal, with quotes and escapes.
std::string literal(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

/// Returns `x` as a C literal of type double.
std::string number(double x) {
  std::string out = to_text(x);
  if (out.find_first_of(".en") == std::string::npos) out += ".0";
  return out;
}

/// Name of the enum ugoki_field_type for an arithmetic type of C; empty: none.
std::string field_type(const std::string& base) {
  static const std::map<std::string, std::string> types = {
      {"double", "F64"},   {"float", "F32"},        {"int", "I32"},           {"signed int", "I32"},
      {"signed", "I32"},   {"int32_t", "I32"},      {"unsigned", "U32"},      {"unsigned int", "U32"},
      {"uint32_t", "U32"}, {"long", "I64"},         {"long int", "I64"},      {"long long", "I64"},
      {"int64_t", "I64"},  {"ptrdiff_t", "I64"},    {"unsigned long", "U64"}, {"unsigned long long", "U64"},
      {"uint64_t", "U64"}, {"size_t", "U64"},       {"char", "I8"},           {"signed char", "I8"},
      {"int8_t", "I8"},    {"unsigned char", "U8"}, {"uint8_t", "U8"},        {"bool", "U8"},
      {"_Bool", "U8"}};
  const auto found = types.find(base);
  return found == types.end() ? "" : "UGOKI_" + found->second;
}

/// True if the C type `base` is an integer type or bool.
bool is_whole(const std::string& base) { return base != "double" && base != "float" && base != "real"; }

/// Writes the wrapper code of one source file.
class Writer {
 public:
  Writer(const CSource& source, std::string path, bool cpp) : source_(source), path_(std::move(path)), cpp_(cpp) {
    location_ = std::filesystem::path(path_).filename().string();
  }

  Result<Wrapper> write(const std::string& name) {
    out_.code = "#include <ugoki/lsi.h>\n";
    if (cpp_) out_.code += "#include <exception>\n#include <new>\n#include <type_traits>\n";
    if (source_.declares_lsis) out_.code += "#include <ugoki/lsi.hpp>\n";
    out_.code += "#include " + literal(path_) + "\n" + end_of_user_code();
    if (source_.declares_lsis) {
      const Annotation* version = source_.file.find("version");
      out_.code +=
          "UGOKI_LIBRARY(" + literal(name) + ", " + literal(version ? version->doc : "") + ", " + literal(source_.file.doc) + ")\n";
      return std::move(out_);
    }
    out_.code +=
        "static double ugoki_gen_in(const ugoki_call* c, int i) { return *(const double*)c->in[i]; }\n"
        "static double ugoki_gen_whole(double x) { return x < 0 ? (double)(long long)(x - 0.5) : (double)(long long)(x + 0.5); }\n"
        "typedef double (*ugoki_gen_used)(double);\n";
    for (const CFunction& f : source_.functions) add(f);
    if (out_.lsis.empty() && problems_.empty()) {
      std::string notes;
      for (const std::string& note : out_.notes) notes += " " + note;
      problems_.add(ErrorCode::structure, location_, "The file has no function that can become an LSI." + notes,
                    "Write a function that takes numbers and returns a number, for example: double twice(double x) { return 2 * x; }");
    }
    if (!problems_.empty()) return fail(std::move(problems_));
    out_.code += "UGOKI_MANIFEST(ugoki_lsi_manifest, " + literal("library " + name) + ")\n";
    for (std::size_t i = 0; i < out_.lsis.size(); ++i)
      out_.code += "UGOKI_MANIFEST(" + id("manifest", i) + ", " + literal("lsi " + out_.lsis[i]) + ")\n";
    out_.code += "static const ugoki_class* const ugoki_gen_classes[] = {";
    for (std::size_t i = 0; i < out_.lsis.size(); ++i) out_.code += (i ? ", &" : "&") + id("class", i);
    const Annotation* version = source_.file.find("version");
    out_.code += "};\nstatic const ugoki_library ugoki_gen_library = {sizeof(ugoki_library), UGOKI_LSI_ABI, " + literal(name) + ", " +
                 literal(version ? version->doc : "") + ", " + literal(source_.file.find("library") ? source_.file.doc : "") +
                 ", ugoki_gen_classes, " + std::to_string(out_.lsis.size()) + ", 0};\n";
    if (cpp_) out_.code += "extern \"C\" ";
    out_.code +=
        "UGOKI_EXPORT const ugoki_library* ugoki_lsi_library(void) {\n  (void)(ugoki_gen_used)ugoki_gen_whole; (void)ugoki_gen_in;\n"
        "  return &ugoki_gen_library;\n}\n";
    return std::move(out_);
  }

 private:
  /// Preprocessor line from which on the compiler attributes errors to generated code, no longer to the user's file.
  static std::string end_of_user_code() { return "#line 1 " + literal(generated_file) + "\n"; }
  /// Name of a generated object: "ugoki_gen_inputs_3" for the table `kind` of LSI n.
  static std::string id(const char* kind, std::size_t n) { return "ugoki_gen_" + std::string(kind) + "_" + std::to_string(n); }

  /// Adds the note that a function does not become an LSI, with the reason.
  void note(const CFunction& f, const std::string& why) {
    out_.notes.push_back(location_ + ":" + std::to_string(f.line) + ": '" + f.name + "' does not become an LSI: " + why);
  }

  /// The struct of a parameter that is a state, that is, a pointer or reference to a struct of this file; null if it is not a state.
  [[nodiscard]] const CStruct* state_of(const CVariable& v) const {
    if (v.type.pointers != 1 || v.type.is_const || v.type.elements) return nullptr;
    return source_.find_struct(v.type.base);
  }
  /// True for NAME_init(state), which sets the initial state of the LSI NAME and is not an LSI itself.
  [[nodiscard]] bool is_init(const CFunction& f) const {
    return f.name.ends_with("_init") && f.parameters.size() == 1 && f.result.base == "void" && state_of(f.parameters[0]);
  }

  void add(const CFunction& f) {
    if (f.is_static || is_init(f) || f.comment.find("skip")) return;
    Parts p;
    for (const CVariable& v : f.parameters) {
      const std::string why = add_parameter(f, v, p);
      if (!why.empty()) return note(f, why);
    }
    const bool returns = f.result.by_value() && f.result.numeric();
    if (!returns && f.result.base != "void") return note(f, "it returns '" + f.result.text + "', which is not a number.");
    if (f.result.base == "void" && (f.result.pointers || f.result.elements)) return note(f, "it returns a pointer.");
    if (!returns && p.outputs.empty() && !p.state)
      return note(f, "it has no output: it returns nothing, and no parameter is an output or a state.");
    const bool delayed = f.comment.find("delayed") != nullptr;
    if (returns) {
      const Annotation* a = f.comment.find("return");
      Annotation none;
      none.name = "out";
      Annotation shown = a ? *a : none;
      if (shown.name.empty()) shown.name = "out";
      p.outputs.insert(p.outputs.begin(), output_row(shown.name, 1, &shown, delayed));
    }
    check_annotations(f, p);
    emit(f, p, returns, delayed);
  }

  /// Parts of the generated code of one LSI.
  struct Parts {
    std::vector<std::string> inputs, outputs, parameters;  ///< C text of the rows of the tables of inputs, outputs, parameters
    std::vector<std::string> arguments;                    ///< arguments with which the user's function is called
    std::vector<std::string> before, after;                ///< C statements before and after the call
    std::vector<std::string> names;                        ///< names of the function's parameters
    const CStruct* state = nullptr;
    int numbers = 0;  ///< number of values in ugoki_call::parameters so far
    std::vector<std::string> choice_tables;
  };

  /// The annotation of the function's parameter `name`. If it has several, the one whose keyword comes first in `words`; null: none.
  static const Annotation* about(const CFunction& f, const std::string& name, std::initializer_list<const char*> words) {
    for (const char* word : words)
      if (const Annotation* a = f.comment.find(word, name)) return a;
    return nullptr;
  }

  /// Pin type (enum ugoki_type) of an input or output: as annotated, otherwise by its number of elements.
  std::string type_of(const CFunction& f, const Annotation* a, int elements) {
    static const std::map<std::string, std::pair<std::string, int>> types = {{"scalar", {"UGOKI_SCALAR", 1}},
                                                                             {"vector", {"UGOKI_VECTOR", 3}},
                                                                             {"rotation", {"UGOKI_ROTATION", 4}},
                                                                             {"pose", {"UGOKI_POSE", 7}},
                                                                             {"joint values", {"UGOKI_JOINT_VALUES", 0}}};
    if (a && !a->type.empty()) {
      const auto found = types.find(a->type);
      if (found != types.end() && (found->second.second == elements || found->second.second == 0)) return found->second.first;
      problems_.add(
          ErrorCode::structure, location_ + ":" + std::to_string(a->line ? a->line : f.line),
          "'" + a->name + "' of '" + f.name + "' has " + std::to_string(elements) + " numbers and cannot be of the type '" + a->type + "'.",
          "Use scalar (1 number), vector (3), rotation (4), pose (7) or joint values (any).");
    }
    for (const auto& [name, type] : types)
      if (type.second == elements) return type.first;
    return "UGOKI_JOINT_VALUES";
  }
  static std::string count_of(const std::string& type, int elements) {
    return type == "UGOKI_JOINT_VALUES" ? std::to_string(elements) : "0";
  }
  static std::string texts(const Annotation* a) { return literal(a ? a->unit : "") + ", " + literal(a ? a->doc : ""); }
  static std::string range(const Annotation* a) { return a && a->has_range ? number(a->minimum) + ", " + number(a->maximum) : "0.0, 0.0"; }

  std::string output_row(const std::string& name, int elements, const Annotation* a, bool delayed) {
    const std::string type = type_of({}, a, elements);
    return "{sizeof(ugoki_output), " + type + ", " + (delayed ? "UGOKI_DELAYED" : "0") + ", " + count_of(type, elements) + ", " +
           literal(name) + ", " + texts(a) + ", " + range(a) + ", 0, 0}";
  }

  /// Adds the parameter `v` of the user's function to the LSI: as an input, an output, an LSI parameter, the state, the time or the time
  /// step. @return the reason if this is impossible; empty: done
  std::string add_parameter(const CFunction& f, const CVariable& v, Parts& p) {
    if (const CStruct* s = state_of(v)) {
      if (p.state) return "it has two parameters that are states.";
      p.state = s;
      p.arguments.push_back(std::string(v.type.reference ? "*" : "") + "(" + s_name(*s) + "*)call->state");
      return {};
    }
    if (v.name.empty()) return "a parameter has no name.";
    p.names.push_back(v.name);
    const CType& t = v.type;
    if (!t.numeric())
      return "its parameter '" + v.name + "' is of the type '" + t.text + "', which is neither a number nor a struct of this file.";
    const bool real = t.base == "double" || t.base == "float";
    const bool annotated = about(f, v.name, {"in", "out", "parameter"}) != nullptr;
    if (t.by_value() && real && (f.comment.find("dt", v.name) || (v.name == "dt" && !annotated))) {
      p.arguments.push_back("(" + t.base + ")call->tick->dt");
      return {};
    }
    if (t.by_value() && real && f.comment.find("time", v.name)) {
      p.arguments.push_back("(" + t.base + ")call->tick->time");
      return {};
    }
    if (t.by_value() && f.comment.find("parameter", v.name)) return add_constant(f, v, p);
    const bool scalar_reference = t.reference && t.pointers == 1 && !t.elements;
    if (t.by_value() || (t.is_const && scalar_reference)) return add_input(f, v, p, 1);
    if (t.elements && t.pointers == 0) {
      if (t.is_const || f.comment.find("in", v.name)) return add_input(f, v, p, t.elements);
      return add_output(f, v, p, t.elements);
    }
    if (t.pointers == 1 && !t.elements && !t.is_const) {
      if (const CVariable* count = count_behind(f, v); count && !t.reference && !f.comment.find("out", v.name))
        return "its parameter '" + v.name + "' may be an array of '" + count->name + "' numbers. Write 'double " + v.name +
               "[3]' for an array of 3 outputs, 'const double " + v.name + "[3]' for an array of 3 inputs, or '@out " + v.name +
               "' in the comment if it is one output.";
      return add_output(f, v, p, 1);
    }
    return "the number of elements of its parameter '" + v.name + "' is unknown. Write for example 'const double " + v.name + "[3]'.";
  }

  /// The parameter that follows the pointer `v`, if it is an integer whose name states a count ("n", "count", "x_size"); otherwise null.
  static const CVariable* count_behind(const CFunction& f, const CVariable& v) {
    const auto at = std::find_if(f.parameters.begin(), f.parameters.end(), [&](const CVariable& other) { return &other == &v; });
    if (at == f.parameters.end() || at + 1 == f.parameters.end()) return nullptr;
    const CVariable& next = *(at + 1);
    if (!next.type.by_value() || !is_whole(next.type.base)) return nullptr;
    if (next.type.base == "size_t" || next.name == "n" || next.name == "n" + v.name || next.name == "n_" + v.name) return &next;
    std::string name = next.name;
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const char* word : {"count", "size", "len", "num"})
      if (name.find(word) != std::string::npos) return &next;
    return nullptr;
  }

  std::string add_input(const CFunction& f, const CVariable& v, Parts& p, int elements) {
    const Annotation* a = about(f, v.name, {"in", "param"});
    const std::string type = type_of(f, a, elements), index = std::to_string(p.inputs.size());
    const std::string flags = std::string(a && a->has_value ? "UGOKI_OPTIONAL" : "0") + (f.comment.find("delayed") ? " | UGOKI_LATE" : "");
    p.inputs.push_back("{sizeof(ugoki_input), " + type + ", " + flags + ", " + count_of(type, elements) + ", " + literal(v.name) + ", " +
                       texts(a) + ", " + number(a && a->has_value ? a->value : 0) + ", " + range(a) + "}");
    const std::string payload = "(const double*)call->in[" + index + "]";
    if (v.type.elements == 0) {
      const std::string value = "ugoki_gen_in(call, " + index + ")";
      p.arguments.push_back("(" + v.type.base + ")" + (is_whole(v.type.base) ? "ugoki_gen_whole(" + value + ")" : value));
    } else if (v.type.base == "double" && v.type.is_const) {
      p.arguments.push_back(payload);
    } else {
      const std::string local = "ugoki_gen_in_" + index;
      p.before.push_back(v.type.base + " " + local + "[" + std::to_string(elements) + "]; for (int i = 0; i < " + std::to_string(elements) +
                         "; ++i) " + local + "[i] = (" + v.type.base + ")" + (is_whole(v.type.base) ? "ugoki_gen_whole" : "") + "((" +
                         payload + ")[i]);");
      p.arguments.push_back(local);
    }
    return {};
  }

  std::string add_output(const CFunction& f, const CVariable& v, Parts& p, int elements) {
    const Annotation* a = about(f, v.name, {"out", "param"});
    const std::size_t index = p.outputs.size() + (f.result.by_value() && f.result.numeric() ? 1 : 0);
    p.outputs.push_back(output_row(v.name, elements, a, f.comment.find("delayed") != nullptr));
    const std::string payload = "(double*)call->out[" + std::to_string(index) + "]";
    if (v.type.base == "double") {
      p.arguments.push_back((v.type.reference ? "*" : "") + payload);
      return {};
    }
    const std::string local = "ugoki_gen_out_" + std::to_string(index), n = std::to_string(elements);
    p.before.push_back(v.type.base + " " + local + "[" + n + "]; for (int i = 0; i < " + n + "; ++i) " + local + "[i] = 0;");
    p.arguments.push_back((v.type.reference ? "*" : "") + local);
    p.after.push_back("for (int i = 0; i < " + n + "; ++i) (" + payload + ")[i] = (double)" + local + "[i];");
    return {};
  }

  std::string add_constant(const CFunction& f, const CVariable& v, Parts& p) {
    const Annotation* a = f.comment.find("parameter", v.name);
    std::string kind = "UGOKI_NUMBER", choices = "0", initial = number(a->value), table = "0";
    if (v.type.base == "bool" || v.type.base == "_Bool") {
      kind = "UGOKI_BOOLEAN";
      if (a->word_value == "true") initial = "1.0";
    } else if (!a->choices.empty()) {
      kind = "UGOKI_CHOICE";
      choices = std::to_string(a->choices.size());
      table = "ugoki_gen_choices_" + std::to_string(out_.lsis.size()) + "_" + std::to_string(p.choice_tables.size());
      std::string words;
      for (const std::string& w : a->choices) words += (words.empty() ? "" : ", ") + literal(w);
      p.choice_tables.push_back("static const char* const " + table + "[] = {" + words + "};\n");
      const auto found = std::find(a->choices.begin(), a->choices.end(), a->word_value);
      if (!a->word_value.empty() && found == a->choices.end())
        problems_.add(ErrorCode::unknown, location_ + ":" + std::to_string(a->line),
                      "'" + a->word_value + "' is not one of the choices of '" + v.name + "'.", "Write one of the words in the braces.");
      if (found != a->choices.end()) initial = number(static_cast<double>(found - a->choices.begin()));
    } else if (is_whole(v.type.base)) {
      kind = "UGOKI_INTEGER";
    }
    if (a->has_range && (a->value < a->minimum || a->value > a->maximum))
      problems_.add(ErrorCode::range, location_ + ":" + std::to_string(a->line),
                    "The initial value " + to_text(a->value) + " of '" + v.name + "' is outside of its range " + to_text(a->minimum) +
                        ".." + to_text(a->maximum) + ".",
                    "Write another value after '='.");
    p.parameters.push_back("{sizeof(ugoki_parameter), " + kind + ", 0, " + choices + ", " + literal(v.name) + ", " + texts(a) + ", {" +
                           initial + ", 0.0, 0.0}, " + range(a) + ", " + table + ", 0}");
    p.arguments.push_back("(" + v.type.base + ")call->parameters[" + std::to_string(p.numbers++) + "]");
    return {};
  }

  /// Adds a problem for each annotation that names no parameter of the function.
  void check_annotations(const CFunction& f, const Parts& p) {
    for (const Annotation& a : f.comment.annotations) {
      const bool names = a.word == "in" || a.word == "out" || a.word == "parameter" || a.word == "dt" || a.word == "time";
      if (!names || std::find(p.names.begin(), p.names.end(), a.name) != p.names.end()) continue;
      problems_.add(ErrorCode::unknown, location_ + ":" + std::to_string(a.line),
                    "The annotation '" + a.word + "' names '" + a.name + "', but '" + f.name + "' has no parameter of this name.",
                    "Correct the name, or remove the annotation.");
    }
  }

  /// Rows of the table of the state's fields; empty if the struct has fields of other types than numbers.
  std::vector<std::string> field_rows(const CFunction& f, const CStruct& s) {
    std::vector<std::string> rows;
    if (!s.understood) return rows;
    for (const CVariable& v : s.fields) {
      const std::string type = field_type(v.type.base);
      if (type.empty()) continue;
      Annotation own = read_field_comment(v);
      if (const Annotation* a = f.comment.find("state", v.name)) own = *a;
      rows.push_back("{sizeof(ugoki_field), " + type + ", (uint32_t)offsetof(" + s_name(s) + ", " + v.name + "), " +
                     std::to_string(std::max(1, v.type.elements)) + ", " + literal(v.name) + ", " + texts(&own) + ", " +
                     number(own.has_value ? own.value : 0) + "}");
    }
    return rows;
  }
  static Annotation read_field_comment(const CVariable& v);
  static std::string s_name(const CStruct& s) { return s.full; }

  /// C code that defines a constant array with these rows; empty if there are no rows.
  static std::string table(const char* type, const std::string& name, const std::vector<std::string>& rows) {
    if (rows.empty()) return {};
    std::string out = "static const " + std::string(type) + " " + name + "[] = {\n";
    for (const std::string& row : rows) out += "  " + row + ",\n";
    return out + "};\n";
  }

  /// Writes the tables, the `run` function and the class of one LSI.
  void emit(const CFunction& f, const Parts& p, bool returns, bool delayed) {
    const std::size_t n = out_.lsis.size();
    std::string& code = out_.code;
    for (const std::string& t : p.choice_tables) code += t;
    const std::vector<std::string> fields = p.state ? field_rows(f, *p.state) : std::vector<std::string>();
    code += table("ugoki_input", id("inputs", n), p.inputs) + table("ugoki_output", id("outputs", n), p.outputs) +
            table("ugoki_parameter", id("parameters", n), p.parameters) + table("ugoki_field", id("fields", n), fields);
    std::string call = f.name + "(";
    for (std::size_t i = 0; i < p.arguments.size(); ++i) call += (i ? ", " : "") + p.arguments[i];
    call += ");";
    code += "static int32_t " + id("run", n) + "(const ugoki_call* call) {\n  (void)call;\n";
    for (const std::string& line : p.before) code += "  " + line + "\n";
    if (cpp_) code += "  try {\n";
    code += "#line " + std::to_string(f.line) + " " + literal(path_) + "\n  " + (returns ? "*(double*)call->out[0] = (double)" : "") +
            call + "\n" + end_of_user_code();
    if (cpp_)
      code +=
          "  } catch (const std::exception& e) {\n    return ugoki_stop(call, e.what());\n  } catch (...) {\n"
          "    return ugoki_stop(call, \"The function threw an exception that is not a std::exception.\");\n  }\n";
    for (const std::string& line : p.after) code += "  " + line + "\n";
    code += "  return 0;\n}\n";
    const std::string init = emit_init(f, p, n);
    const Annotation* name = f.comment.find("lsi");
    const Annotation* group = f.comment.find("group");
    const Annotation* version = f.comment.find("version");
    const auto colon = f.name.rfind("::");
    const std::string shown = name && !name->doc.empty() ? name->doc : colon == std::string::npos ? f.name : f.name.substr(colon + 2);
    const auto table_name = [&](const char* kind, const std::vector<std::string>& rows) {
      return rows.empty() ? std::string("0") : id(kind, n);
    };
    code += "static const ugoki_class " + id("class", n) + " = {sizeof(ugoki_class), " +
            (version && parse_long(version->doc) ? version->doc : "1") + ", " + literal(shown) + ", " + literal(f.comment.doc) + ", " +
            (group ? literal(group->doc) : "0") + ", " + table_name("inputs", p.inputs) + ", " + table_name("outputs", p.outputs) + ", " +
            table_name("parameters", p.parameters) + ", " + table_name("fields", fields) + ", " + std::to_string(p.inputs.size()) + ", " +
            std::to_string(p.outputs.size()) + ", " + std::to_string(p.parameters.size()) + ", " + std::to_string(fields.size()) + ", " +
            (p.state ? "sizeof(" + s_name(*p.state) + ")" : "0") + ", " + init + ", " + (delayed ? "0" : id("run", n)) + ", " +
            (delayed ? id("run", n) : "0") + ", 0, 0, 0, 0};\n";
    out_.lsis.push_back(shown);
  }

  /// Writes the `init` function of an LSI. @return its name; "0" if the initial values of the fields are enough
  std::string emit_init(const CFunction& f, const Parts& p, std::size_t n) {
    if (!p.state) return "0";
    const CFunction* init = source_.find_function(f.name + "_init");
    const bool has = init && is_init(*init) && state_of(init->parameters[0]) == p.state;
    if (!has && !cpp_) return "0";
    std::string& code = out_.code;
    code += "static int32_t " + id("init", n) + "(const ugoki_call* call) {\n";
    if (cpp_) {
      const std::string type = s_name(*p.state);
      code += "  static_assert(std::is_trivially_copyable_v<" + type +
              ">, \"The struct of a state must be trivially copyable: plain data without pointers to memory, strings or containers.\");\n";
      const bool commented = std::any_of(p.state->fields.begin(), p.state->fields.end(), [&](const CVariable& v) {
        return f.comment.find("state", v.name) != nullptr || read_field_comment(v).has_value;
      });
      if (!commented) code += "  new (call->state) " + type + "{};\n";
    }
    if (has) {
      code += "#line " + std::to_string(init->line) + " " + literal(path_) + "\n  " + init->name + "(" +
              (init->parameters[0].type.reference ? "*" : "") + "(" + s_name(*p.state) + "*)call->state);\n" + end_of_user_code();
    }
    code += "  return 0;\n}\n";
    return id("init", n);
  }

  const CSource& source_;
  std::string path_, location_;
  bool cpp_;
  Wrapper out_;
  Error problems_;
};

Annotation Writer::read_field_comment(const CVariable& v) {
  Annotation a = read_annotation("state " + v.name + " " + v.comment);
  if (!a.has_value && !v.initial.empty())
    if (const auto x = parse_double(v.initial)) {
      a.value = *x;
      a.has_value = true;
    }
  return a;
}

}  // namespace

Result<Wrapper> make_wrapper(const CSource& source, const std::string& path, const std::string& name, bool cpp) {
  return Writer(source, path, cpp).write(name);
}

}  // namespace ugoki::plugin
