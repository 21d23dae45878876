#include "ugoki/fmi/code.h"

#include <dlfcn.h>

#include <filesystem>
#include <set>

#include "ugoki/base/floating_point_mode.h"
#include "ugoki/files/files.h"

namespace ugoki::fmi {
namespace {

namespace fs = std::filesystem;

#if defined(__aarch64__)
constexpr const char* platform2 = "aarch64-linux";
constexpr const char* platform3 = "aarch64-linux";
#else
constexpr const char* platform2 = "linux64";
constexpr const char* platform3 = "x86_64-linux";
#endif

std::string platform_folder(const ModelDescription& d) { return std::string("binaries/") + (d.version == 2 ? platform2 : platform3) + "/"; }

Result<void> unpack(const Archive& archive, const std::string& name, const std::string& folder) {
  const Result<std::string> bytes = archive.read(name);
  if (!bytes) return fail(bytes.error());
  std::error_code ec;
  fs::create_directories(fs::path(folder + "/" + name).parent_path(), ec);
  return files::write_file(folder + "/" + name, std::string_view(*bytes));
}

/// URI of a path. Bytes other than letters, digits and /-._~ are written as %XX.
std::string file_uri(const std::string& path) {
  constexpr const char* digits = "0123456789ABCDEF";
  std::string out = "file://";
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("/-._~").find(c) != std::string_view::npos;
    if (plain) {
      out += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    out += {'%', digits[byte >> 4], digits[byte & 15]};
  }
  return out;
}

}  // namespace

std::string binary_name(const ModelDescription& d) { return platform_folder(d) + d.identifier + ".so"; }

Result<void> check_binary(const Archive& archive, const ModelDescription& d, std::string_view location) {
  if (archive.has(binary_name(d))) return {};
  std::set<std::string> systems;
  bool sources = false;
  for (const ArchiveEntry& e : archive.entries()) {
    sources = sources || e.name.starts_with("sources/");
    if (!e.name.starts_with("binaries/")) continue;
    const std::string rest = e.name.substr(9);
    if (const auto slash = rest.find('/'); slash != std::string::npos) systems.insert(rest.substr(0, slash));
  }
  std::string message = "The FMU has no binary for this system ('" + binary_name(d) + "')";
  if (!systems.empty()) {
    message += "; it has binaries for";
    for (const std::string& s : systems) message += " " + s;
  } else if (sources) {
    message += ", only sources";
  }
  return fail(ErrorCode::unsupported, std::string(location), message + ".",
              "Export the FMU for Linux, or ask its author for a Linux version.");
}

Result<std::shared_ptr<Code>> Code::open(const Archive& archive, const ModelDescription& d, std::string_view place_view) {
  const std::string location(place_view);
  if (Result<void> there = check_binary(archive, d, location); !there) return fail(std::move(there.error()));
  Result<files::TemporaryFolder> made = files::TemporaryFolder::make("fmu", location);
  if (!made) return fail(std::move(made.error()));
  const std::shared_ptr<Code> code(new Code(std::move(*made)));
  const std::string& folder = code->folder_.path();
  for (const ArchiveEntry& e : archive.entries())
    if (e.name.starts_with(platform_folder(d)) || e.name.starts_with("resources/"))
      if (Result<void> done = unpack(archive, e.name, folder); !done) return fail(std::move(done.error()));
  std::error_code ec;
  fs::create_directories(folder + "/resources", ec);
  code->resources_ = d.version == 2 ? file_uri(folder + "/resources") : folder + "/resources/";

  // The library is never closed: some FMUs start threads that outlive their instances and would then run unmapped code.
  const KeepFloatingPointMode keep;  // a library linked with -ffast-math sets the mode when it is loaded
  void* handle = ::dlopen((folder + "/" + binary_name(d)).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) {
    const char* why = dlerror();
    std::string reason = why ? why : "unknown reason";
    if (const auto at = reason.find(folder + "/"); at != std::string::npos) reason.erase(at, folder.size() + 1);
    return fail(ErrorCode::syntax, location, "The FMU's binary cannot be opened: " + reason + ".",
                "Install the libraries that it needs, or export it for this system.");
  }
  std::string missing;
  const auto find = [&](auto& function, const char* name, bool needed) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(handle, name));
    if (!function && needed) missing += (missing.empty() ? "" : ", ") + std::string(name);
  };
  const auto is_needed = [&](std::string_view name) {
    if (name == "EnterEventMode" || name == "UpdateDiscreteStates" || name == "EnterStepMode") return d.event_mode;
    return name.find("FMU") == std::string_view::npos || d.saves_state;
  };
  if (d.version == 2) {
#define UGOKI_FMI_FIND(result, name, arguments) find(code->two_.name, "fmi2" #name, is_needed(#name));
    UGOKI_FMI2_FUNCTIONS(UGOKI_FMI_FIND)
#undef UGOKI_FMI_FIND
  } else {
#define UGOKI_FMI_FIND(result, name, arguments) find(code->three_.name, "fmi3" #name, is_needed(#name));
    UGOKI_FMI3_FUNCTIONS(UGOKI_FMI_FIND)
#undef UGOKI_FMI_FIND
#define UGOKI_FMI_FIND(type)                           \
  find(code->three_.Get##type, "fmi3Get" #type, true); \
  find(code->three_.Set##type, "fmi3Set" #type, true);
    UGOKI_FMI3_NUMBERS(UGOKI_FMI_FIND)
#undef UGOKI_FMI_FIND
  }
  if (!missing.empty())
    return fail(ErrorCode::structure, location, "The FMU's binary lacks functions: " + missing + ".",
                "Export it again for FMI " + d.written + " co-simulation.");
  return code;
}

}  // namespace ugoki::fmi
