#include "lsi_template.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "ugoki/files/files.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

const char* const c_source = R"(/// @library NAME
/// LSIs of my own.

/// State of the damped spring.
struct NAME_state {
  double peak; /* [N] maximum force so far */
};

/// A spring with a damper. Its force pulls towards the rest position.
/// @in x [m] -1..1  Extension from the rest position.
/// @in v [m/s] = 0  Rate of extension.
/// @parameter stiffness [N/m] = 100, 0..1e6  Force per metre of extension.
/// @parameter damping [N s/m] = 2, 0..1e4  Damping force per unit of speed.
/// @return force [N]  Force on the attached body.
/// @out peak [N]  Maximum force so far.
double NAME(struct NAME_state* state, double x, double v, double stiffness, double damping, double* peak) {
  const double force = -stiffness * x - damping * v;
  const double size = force < 0 ? -force : force;
  if (size > state->peak) state->peak = size;
  *peak = state->peak;
  return force;
}
)";

const char* const cpp_source = R"(// LSIs of my own.
#include <ugoki/lsi.hpp>

#include <cmath>

/// A spring with a damper. Its force pulls towards the rest position.
struct NAME_lsi {
  double x = 0, v = 0;
  double stiffness = 100, damping = 2;
  double force = 0, peak = 0;

  void step() {
    force = -stiffness * x - damping * v;
    peak = std::fmax(peak, std::fabs(force));
  }
};

UGOKI_LSI(NAME_lsi, "NAME", "A spring with a damper. Its force pulls towards the rest position.",
          ugoki::in(&NAME_lsi::x, "x", "m", "Extension from the rest position.", {-1, 1}),
          ugoki::in(&NAME_lsi::v, "v", "m/s", "Rate of extension."),
          ugoki::parameter(&NAME_lsi::stiffness, "stiffness", "N/m", "Force per metre of extension.", {0, 1e6}),
          ugoki::parameter(&NAME_lsi::damping, "damping", "N s/m", "Damping force per unit of speed.", {0, 1e4}),
          ugoki::out(&NAME_lsi::force, "force", "N", "Force on the attached body."),
          ugoki::out(&NAME_lsi::peak, "peak", "N", "Maximum force so far."),
          ugoki::state(&NAME_lsi::peak, "peak", "N", "Maximum force so far."))

UGOKI_LIBRARY("NAME", "1.0", "LSIs of my own.")
)";

const char* const test = R"({
  "doc": "A spring that is extended, then compressed.",
  "dt": 0.01,
  "circuit": {
    "version": 1,
    "name": "NAME test",
    "inputs": [{"name": "x", "type": "scalar", "to": "spring.x"}],
    "lsis": [{"id": "spring", "type": "NAME/NAME", "parameters": {"stiffness": 10}}]
  },
  "given": [
    {"tick": 0, "pin": "x", "value": 0.5},
    {"tick": 1, "pin": "x", "value": -0.25}
  ],
  "expect": [
    {"tick": 0, "pin": "spring.force", "value": -5},
    {"tick": 1, "pin": "spring.force", "value": 2.5},
    {"tick": 1, "pin": "spring.peak", "value": 5}
  ]
}
)";

const char* const readme = R"(# NAME

A library of software LSIs for Ugoki.

    ugoki lsi test .                 # builds FILE and runs NAME.test.json
    ugoki lsi build FILE --install   # builds and installs the library
    ugoki lsi watch FILE             # rebuilds and reinstalls it whenever FILE changes; running circuits reload it

Each function of the file becomes an LSI; the comment above it declares its pins. See docs/lsi.md of Ugoki.
)";

std::string filled(std::string text, const std::string& name, const std::string& file) {
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"NAME", name}, {"FILE", file}})
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

}  // namespace

Result<std::vector<std::string>> make_template(const std::string& path, bool cpp) {
  const std::string name = fs::path(path).filename().string();
  const bool good = !name.empty() && std::isalpha(static_cast<unsigned char>(name[0])) && name.size() <= 60 &&
                    std::all_of(name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; });
  if (!good)
    return fail(ErrorCode::syntax, path, "'" + name + "' cannot be the name of a library.", "Use letters, digits and '_', a letter first.");
  std::error_code ec;
  if (fs::exists(path, ec)) return fail(ErrorCode::conflict, path, "A file or folder of this name already exists.", "Choose another name.");
  fs::create_directories(path, ec);
  if (ec) return fail(ErrorCode::io, path, "The folder cannot be created: " + ec.message() + ".", "Choose another location.");
  const std::string source = name + (cpp ? ".cpp" : ".c");
  std::vector<std::string> written;
  for (const auto& [file, text] :
       {std::pair<std::string, const char*>{source, cpp ? cpp_source : c_source}, {name + ".test.json", test}, {"README.md", readme}}) {
    written.push_back(path + "/" + file);
    if (Result<void> done = files::write_file(written.back(), std::string_view(filled(text, name, source))); !done)
      return fail(done.error());
  }
  return written;
}

}  // namespace ugoki::cli
