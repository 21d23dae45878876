#pragma once
// What the tests of FMUs share: FMUs packed from the units, and circuits with them.

#include <utility>
#include <vector>

#include "../plugin/folder_test.h"
#include "ugoki/files/files.h"
#include "ugoki/fmi/archive.h"
#include "ugoki/plugin/live_library.h"

namespace ugoki::fmi {

inline std::string text_of(const std::string& path) {
  const Result<std::string> text = files::read_file(path);
  EXPECT_TRUE(text) << path;
  return text ? *text : "";
}
inline std::string description_of(const std::string& model, int version) {
  return text_of(std::string(UGOKI_SOURCE_DIR) + "/tests/fmi/units/" + model + ".fmi" + std::to_string(version) + ".xml");
}
inline std::string code_of(const std::string& model, int version) {
  return text_of(std::string(UGOKI_UNITS) + "/ugoki_unit_" + model + "_" + std::to_string(version) + ".so");
}

class FmiTest : public plugin::FolderTest {
 protected:
  using Files = std::vector<std::pair<std::string, std::string>>;

  std::string pack(const std::string& name, const Files& files) const {
    const Result<std::string> bytes = write_archive(files, name);
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
    return write(name, bytes ? *bytes : "");
  }
  /// An FMU of a model of tests/fmi/units. @param identifier as in its description @return its path
  std::string unit(const std::string& model, const std::string& identifier, int version, std::string description = {}) const {
    if (description.empty()) description = description_of(model, version);
    const std::string system = version == 2 ? "linux64" : "x86_64-linux";
    return pack(identifier + std::to_string(version) + ".fmu", {{"modelDescription.xml", std::move(description)},
                                                                {"binaries/" + system + "/" + identifier + ".so", code_of(model, version)},
                                                                {"resources/note.txt", "read me"}});
  }
  plugin::LiveLibrary library(const std::string& fmu) const { return plugin::LiveLibrary(signals_, {}, {fmu}); }

  /// A circuit of one LSI, "u". @param rest of the instance, of the circuit
  static circuit::Circuit alone(const std::string& type, const std::string& rest = {}, const std::string& of_circuit = {}) {
    return parse(R"({"version": 1, "name": "test", "lsis": [{"id": "u", "type": ")" + type + "\"" + rest + "}]" + of_circuit + "}");
  }
  static Result<circuit::Interpreter> build(const circuit::Circuit& c, const plugin::LiveLibrary& live, double dt) {
    return circuit::Interpreter::build(c, *live.library(), nullptr, {.dt = dt});
  }
};

}  // namespace ugoki::fmi
