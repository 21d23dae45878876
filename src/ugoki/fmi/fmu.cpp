#include "ugoki/fmi/fmu.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "ugoki/base/sha256.h"
#include "ugoki/files/files.h"
#include "ugoki/fmi/archive.h"

namespace ugoki::fmi {
namespace {

constexpr std::size_t max_bytes = std::size_t{1} << 30;   // maximum size of an FMU file; larger files are refused
constexpr std::size_t max_state = std::size_t{64} << 20;  // bytes of a saved state, as for all LSIs (ugoki/lsi.h)

Result<ModelDescription> read_description(const Archive& archive, const std::string& path) {
  constexpr std::string_view name = "modelDescription.xml";
  if (!archive.has(name))
    return fail(ErrorCode::structure, path, "The zip has no modelDescription.xml, so it is not an FMU.",
                "Choose a file that was exported as an FMU.");
  const Result<std::string> xml = archive.read(name);
  if (!xml) return fail(xml.error());
  return read_model_description(*xml, std::filesystem::path(path).filename().string() + "/" + std::string(name));
}

/// Reason for the end of an error message: the last log message of the failed FMU instance, or "it gives no reason".
std::string words_of(const Unit& unit) { return unit.last_words().empty() ? "it gives no reason" : unit.last_words(); }

}  // namespace

void Fmu::begin(const char* what) const {
  if (phase_) phase_("The FMU '" + std::filesystem::path(path_).filename().string() + "' was being " + what);
}
void Fmu::end() const {
  if (phase_) phase_({});
}

Result<std::shared_ptr<Fmu>> Fmu::open(const std::string& path, std::string bytes, std::string hash, Phase phase) {
  const Result<Archive> archive = Archive::open(std::move(bytes), path);
  if (!archive) return fail(archive.error());
  Result<ModelDescription> description = read_description(*archive, path);
  if (!description) return fail(std::move(description.error()));
  if (Result<void> there = check_binary(*archive, *description, path); !there) return fail(std::move(there.error()));
  const std::shared_ptr<Fmu> fmu(new Fmu);
  fmu->path_ = path;
  fmu->hash_ = std::move(hash);
  fmu->phase_ = phase;
  fmu->description_ = std::move(*description);
  Declarations declared = declare(fmu->description_);
  fmu->notes_ = std::move(declared.notes);
  for (Declaration& d : declared.classes) {
    FmuClass c{};
    c.fmu = fmu.get();
    c.declaration = std::move(d);
    fmu->classes_.push_back(std::move(c));
  }
  return fmu;
}

Result<std::shared_ptr<Code>> Fmu::code() {
  if (code_) return *code_;
  const auto load = [this]() -> Result<std::shared_ptr<Code>> {
    Result<std::string> bytes = files::read_file(path_, max_bytes);
    if (!bytes) return fail(std::move(bytes.error()));
    if (sha256(*bytes) != hash_)
      return fail(ErrorCode::conflict, path_, "The file was changed while the circuit was using it.", "Run the circuit again.");
    const Result<Archive> archive = Archive::open(std::move(*bytes), path_);
    if (!archive) return fail(archive.error());
    return Code::open(*archive, description_, path_);
  };
  begin("loaded");
  code_.emplace(load());
  end();
  return *code_;
}

Result<void> Fmu::measure(std::size_t& bytes) {
  bytes = 0;
  const Result<std::shared_ptr<Code>> loaded = code();
  if (!loaded) return fail(loaded.error());
  const std::unique_ptr<Unit> unit = Unit::make(*loaded, description_, "trial of " + description_.identifier, false);
  if (!unit->instantiate())
    return fail(ErrorCode::structure, path_, "The FMU cannot be started: " + words_of(*unit) + ".",
                "Install what it needs, or export it again.");
  if (unit->enter_initialization(0) > Status::warning || unit->exit_initialization() > Status::warning)
    return fail(ErrorCode::structure, path_, "The FMU cannot be initialised with its own start values: " + words_of(*unit) + ".",
                "Set the parameters or inputs that the FMU needs; see its documentation.");
  EventEnd events;
  if (unit->finish_events(events) > Status::warning)
    return fail(ErrorCode::structure, path_, "The FMU cannot handle its first event: " + words_of(*unit) + ".",
                "Set the parameters or inputs that the FMU needs; see its documentation.");
  void* state = nullptr;
  std::size_t size = 0;
  if (description_.serializes_state && unit->get_state(state) <= Status::warning && state) {
    if (unit->serialized_size(state, size) <= Status::warning) bytes = size;
    unit->free_state(state);
  }
  unit->terminate();
  return {};
}

std::size_t Fmu::state_bytes() {
  if (state_bytes_) return *state_bytes_;
  if (!description_.serializes_state) return *(state_bytes_ = 0);
  begin("started");
  std::size_t size = 0;
  const Result<void> measured = measure(size);
  end();
  const std::size_t with_room = size ? (2 * size + 1024) / 8 * 8 : 0;
  state_bytes_ = measured && with_room <= max_state ? with_room : 0;
  return *state_bytes_;
}

Result<void> Fmu::attempt() {
  begin("started");
  std::size_t ignored = 0;
  Result<void> done = measure(ignored);
  end();
  return done;
}

Result<LoadedFmu> load_fmu(const std::string& path, std::string bytes, std::string hash, Phase phase) {
  Result<std::shared_ptr<Fmu>> fmu = Fmu::open(path, std::move(bytes), std::move(hash), phase);
  if (!fmu) return fail(std::move(fmu.error()));
  LoadedFmu out;
  const ModelDescription& d = (*fmu)->description();
  out.name = d.identifier;
  out.version = d.model_version;
  out.doc = (d.description.empty() ? d.name : d.description) + " (FMI " + d.written + (d.tool.empty() ? "" : ", made by " + d.tool) + ")";
  for (const std::string& note : (*fmu)->notes()) out.doc += "\n" + note;
  for (FmuClass& c : (*fmu)->classes()) {
    circuit::LsiClass lsi = c.declaration.lsi_class;
    lsi.abi = &c;
    add_functions(lsi);
    out.classes.push_back(std::move(lsi));
  }
  out.code = std::move(*fmu);
  return out;
}

Result<void> try_fmu(const std::string& path, std::string bytes, std::string hash, Phase phase) {
  const Result<std::shared_ptr<Fmu>> fmu = Fmu::open(path, std::move(bytes), std::move(hash), phase);
  if (!fmu) return fail(fmu.error());
  return (*fmu)->attempt();
}

Result<FmuInfo> read_fmu_info(const std::string& path, std::string bytes) {
  const Result<Archive> archive = Archive::open(std::move(bytes), path);
  if (!archive) return fail(archive.error());
  Result<ModelDescription> description = read_description(*archive, path);
  if (!description) return fail(std::move(description.error()));
  FmuInfo out;
  out.runs_here = archive->has(binary_name(*description));
  std::set<std::string> systems;
  for (const ArchiveEntry& e : archive->entries())
    if (const std::size_t slash = e.name.find('/', 9); e.name.starts_with("binaries/") && slash != std::string::npos)
      systems.insert(e.name.substr(9, slash - 9));
  out.systems.assign(systems.begin(), systems.end());
  out.notes = declare(*description).notes;
  out.description = std::move(*description);
  return out;
}

}  // namespace ugoki::fmi
