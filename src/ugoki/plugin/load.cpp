#include "ugoki/plugin/load.h"

#include <dlfcn.h>
#include <link.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "ugoki/base/floating_point_mode.h"
#include "ugoki/base/sha256.h"
#include "ugoki/circuit/setup.h"
#include "ugoki/files/files.h"
#include "ugoki/files/temporary_folder.h"
#include "ugoki/fmi/archive.h"
#include "ugoki/fmi/load.h"
#include "ugoki/plugin/declarations.h"
#include "ugoki/plugin/guard.h"

namespace ugoki::plugin {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_bytes = std::size_t{1} << 30;  // size of a library's file; larger files are refused

/// A loaded shared library; unloads it when destroyed.
struct Code {
  void* handle = nullptr;
  std::uintptr_t begin = 0, end = 0;  ///< address range of the library's segments
  std::string name;                   ///< name of the library for crash reports; before it is known, the file name
  Code() = default;
  Code(const Code&) = delete;
  Code& operator=(const Code&) = delete;
  ~Code() {
    if (handle) {
      set_phase("The library '" + name + "' was being unloaded");
      dlclose(handle);
      set_phase({});
    }
    if (begin) forget_code(begin);
  }
};

/// Finds the addresses of a loaded library and notes them for crash reports.
void note_addresses(Code& code, const std::string& path) {
  const link_map* map = nullptr;
  if (dlinfo(code.handle, RTLD_DI_LINKMAP, &map) != 0) return;
  code.begin = map->l_addr;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* data) {
        auto& found = *static_cast<Code*>(data);
        if (info->dlpi_addr != found.begin) return 0;
        for (int i = 0; i < info->dlpi_phnum; ++i)
          if (info->dlpi_phdr[i].p_type == PT_LOAD)
            found.end = std::max<std::uintptr_t>(found.end, info->dlpi_addr + info->dlpi_phdr[i].p_vaddr + info->dlpi_phdr[i].p_memsz);
        return 1;
      },
      &code);
  note_code(fs::path(path).filename().string(), code.begin, code.end);
}

/// Loads a library from a private copy of its bytes. Without a copy, dlopen would return the old code for a rebuilt file of the same path,
/// and overwriting the file would change the code that runs.
Result<std::shared_ptr<Code>> open_copy(const std::string& path, const std::string& bytes) {
  const Result<files::TemporaryFolder> folder = files::TemporaryFolder::make("lsi", path);
  if (!folder) return fail(folder.error());
  const std::string copy = folder->path() + "/" + fs::path(path).filename().string();
  const Result<void> written = files::write_file(copy, std::string_view(bytes));
  auto code = std::make_shared<Code>();
  code->name = fs::path(path).filename().string();
  const KeepFloatingPointMode keep;  // a library linked with -ffast-math sets the mode when it is loaded
  if (written) code->handle = dlopen(copy.c_str(), RTLD_NOW | RTLD_LOCAL);
  const char* why = written && !code->handle ? dlerror() : nullptr;
  std::string reason = why ? why : "";
  if (!written) return fail(written.error());
  if (code->handle) {
    note_addresses(*code, path);
    return code;
  }
  if (const auto at = reason.find(copy); at != std::string::npos) reason.replace(at, copy.size(), path);
  return fail(ErrorCode::syntax, path, "The library cannot be opened: " + reason + ".", "Build it on this machine: ugoki lsi build FILE.c");
}

/// LsiClass::make of a plug-in: calls ugoki_class::create.
void* create_object(circuit::Setup& setup) {
  const circuit::LsiClass& c = setup.lsi_class();
  const std::vector<double> numbers = setup.numbers();
  std::vector<const char*> texts;
  for (std::size_t i = 0; i < c.parameters.size(); ++i)
    if (c.parameters[i].kind == circuit::ParameterKind::text) texts.push_back(std::get_if<std::string>(&setup.parameters()[i])->c_str());
  std::vector<std::uint32_t> in_count, out_count;
  for (std::size_t i = 0; i < c.inputs.size(); ++i) in_count.push_back(setup.in(i).count);
  for (const circuit::Shape& s : setup.outputs()) out_count.push_back(s.count);
  char reason[512] = {};
  ugoki_setup given{};
  given.size = sizeof given;
  given.dt = setup.dt();
  given.parameters = numbers.data();
  given.texts = texts.data();
  given.in_count = in_count.data();
  given.out_count = out_count.data();
  given.reason = reason;
  given.reason_size = sizeof reason;
  void* object = c.abi->create(&given);
  reason[sizeof reason - 1] = '\0';
  if (!object)
    setup.fail(ErrorCode::structure, std::string("The LSI cannot be created: ") + (reason[0] ? reason : "it gives no reason."),
               "Check its parameters and wires.");
  return object;
}

/// Reads the file of a library, and computes its hash. Errors: see check_library_file().
Result<std::string> read_checked(const std::string& path, const std::string& expected, std::string& hash) {
  Result<std::string> bytes = files::read_regular_file(path, max_bytes);
  if (!bytes) return bytes;
  hash = sha256(*bytes);
  if (!expected.empty() && hash != expected)
    return fail(ErrorCode::conflict, path, "The file has changed since it was installed: its SHA-256 is now " + hash + ".",
                "Install it again if you trust it: ugoki lsi install FILE");
  return bytes;
}

/// Implements load_library() for an FMU.
Result<LoadedLibrary> load_unit(const std::string& path, std::string bytes, const std::string& hash) {
  Result<fmi::LoadedFmu> fmu = fmi::load_fmu(path, std::move(bytes), hash, set_phase);
  if (!fmu) return fail(std::move(fmu.error()));
  return LoadedLibrary{std::move(fmu->name),    std::move(fmu->version), std::move(fmu->doc), hash,
                       std::move(fmu->classes), std::move(fmu->code)};
}

}  // namespace

Result<void> check_library_file(const std::string& path, const std::string& hash) {
  std::string own;
  const Result<std::string> bytes = read_checked(path, hash, own);
  if (!bytes) return fail(bytes.error());
  return {};
}

Result<LoadedLibrary> load_library(const std::string& path, const std::string& hash) {
  LoadedLibrary out;
  Result<std::string> bytes = read_checked(path, hash, out.hash);
  if (!bytes) return fail(std::move(bytes.error()));
  if (fmi::is_zip(*bytes)) return load_unit(path, std::move(*bytes), out.hash);
  Result<std::shared_ptr<Code>> code = open_copy(path, *bytes);
  if (!code) return fail(std::move(code.error()));
  const auto entry = reinterpret_cast<const ugoki_library* (*)()>(dlsym((*code)->handle, "ugoki_lsi_library"));
  if (!entry)
    return fail(ErrorCode::syntax, path, "The file is not a library of LSIs: it does not export ugoki_lsi_library.",
                "Build it with: ugoki lsi build FILE.c");
  Error problems;
  Declared declared = read_declarations(entry(), path, problems);
  if (!problems.empty()) return fail(std::move(problems));
  out.name = std::move(declared.name);
  out.version = std::move(declared.version);
  out.doc = std::move(declared.doc);
  out.classes = std::move(declared.classes);
  for (circuit::LsiClass& c : out.classes)
    if (c.abi->create) c.make = create_object;
  forget_code((*code)->begin);
  (*code)->name = out.name;
  note_code(out.name, (*code)->begin, (*code)->end);
  out.code = std::move(*code);
  return out;
}

Result<void> try_library(const std::string& path, const std::string& hash) {
  std::string own;
  Result<std::string> bytes = read_checked(path, hash, own);
  if (!bytes) return fail(std::move(bytes.error()));
  if (fmi::is_zip(*bytes)) return fmi::try_fmu(path, std::move(*bytes), std::move(own), set_phase);
  const Result<LoadedLibrary> library = load_library(path, hash);
  if (!library) return fail(library.error());
  return {};
}

}  // namespace ugoki::plugin
