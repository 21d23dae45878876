#pragma once
// Fixture for tests of FMUs: packs the models of tests/fmi/units as FMUs and builds circuits with them.

#include <utility>
#include <vector>

#include "../plugin/folder_test.h"
#include "ugoki/files/files.h"
#include "ugoki/fmi/archive.h"
#include "ugoki/plugin/live_library.h"

namespace ugoki::fmi {

/// Bytes of a file.
inline std::string text_of(const std::string& path) {
  const Result<std::string> text = files::read_file(path);
  EXPECT_TRUE(text) << path;
  return text ? *text : "";
}
/// modelDescription.xml of a model. @param version version of FMI: 2 or 3
inline std::string description_of(const std::string& model, int version) {
  return text_of(std::string(UGOKI_SOURCE_DIR) + "/tests/fmi/units/" + model + ".fmi" + std::to_string(version) + ".xml");
}
/// Bytes of the binary of a model.
inline std::string code_of(const std::string& model, int version) {
  return text_of(std::string(UGOKI_UNITS) + "/ugoki_unit_" + model + "_" + std::to_string(version) + ".so");
}

class FmiTest : public plugin::FolderTest {
 protected:
  using Files = std::vector<std::pair<std::string, std::string>>;

  /// Writes a zip into the folder. @return its path
  std::string pack(const std::string& name, const Files& files) const {
    const Result<std::string> bytes = write_archive(files, name);
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
    return write(name, bytes ? *bytes : "");
  }
  /// Packs a model of tests/fmi/units as an FMU. @param identifier modelIdentifier of its description
  /// @param description replaces the model's own description; empty: the model's own @return path of the FMU
  std::string unit(const std::string& model, const std::string& identifier, int version, std::string description = {}) const {
    if (description.empty()) description = description_of(model, version);
    const std::string system = version == 2 ? "linux64" : "x86_64-linux";
    return pack(identifier + std::to_string(version) + ".fmu", {{"modelDescription.xml", std::move(description)},
                                                                {"binaries/" + system + "/" + identifier + ".so", code_of(model, version)},
                                                                {"resources/note.txt", "read me"}});
  }
  /// A library of the signal LSIs and the LSIs of an FMU.
  plugin::LiveLibrary library(const std::string& fmu) const { return plugin::LiveLibrary(signals_, {}, {fmu}); }

  /// A circuit with one LSI, "u". @param rest JSON appended to the instance @param of_circuit JSON appended to the circuit
  static circuit::Circuit alone(const std::string& type, const std::string& rest = {}, const std::string& of_circuit = {}) {
    return parse(R"({"version": 1, "name": "test", "lsis": [{"id": "u", "type": ")" + type + "\"" + rest + "}]" + of_circuit + "}");
  }
  static Result<circuit::Interpreter> build(const circuit::Circuit& c, const plugin::LiveLibrary& live, double dt) {
    return circuit::Interpreter::build(c, *live.library(), nullptr, {.dt = dt});
  }
};

}  // namespace ugoki::fmi
