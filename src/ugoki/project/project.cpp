#include "ugoki/project/project.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "ugoki/base/check.h"
#include "ugoki/base/number.h"
#include "ugoki/content/delta.h"
#include "ugoki/content/json_fields.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/project/file_lock.h"
#include "ugoki/project/project_file.h"
#include "ugoki/store/rescue.h"

namespace ugoki::project {
namespace {

constexpr std::int64_t max_history_steps = 10'000;  // maximum number of history steps; older steps are deleted

std::span<const std::byte> bytes_of(std::string_view text) { return {reinterpret_cast<const std::byte*>(text.data()), text.size()}; }

/// A resource that was read and checked but not yet added to the project.
struct Loaded {
  std::string id, kind, name;
  std::vector<std::byte> data;
  MechanismPtr mechanism;
  MotionPtr motion;
};

Result<Loaded> load(std::string_view id, std::string_view kind, std::vector<std::byte> data, const std::string& location) {
  Loaded out{std::string(id), std::string(kind), {}, std::move(data), nullptr, nullptr};
  if (!content::is_id(id, content::max_resource_id))
    return fail(ErrorCode::syntax, location, "'" + out.id + "' cannot be an id.", "Use 1 to 21 letters, digits, '-', '_' or '.'.");
  if (kind == "mechanism") {
    Result<MechanismPtr> mechanism = formats::read_mechanism({reinterpret_cast<const char*>(out.data.data()), out.data.size()}, location);
    if (!mechanism) return fail(std::move(mechanism.error()));
    out.mechanism = std::move(*mechanism);
    out.name = out.mechanism->name();
    return out;
  }
  if (kind == "motion") {
    Result<Motion> motion = formats::read_motion(out.data, location);
    if (!motion) return fail(std::move(motion.error()));
    out.motion = std::make_shared<const Motion>(std::move(*motion));
    out.name = out.motion->name;
    return out;
  }
  return fail(ErrorCode::unsupported, location, "A project can contain mechanisms and motions, but not entries of kind '" + out.kind + "'.",
              "Choose a mechanism or a motion.");
}

/// Renames the finished file `from` to `to`, after flushing it to the disk. Replaces an existing file atomically.
Result<void> move_into_place(const std::string& from, const std::string& to) {
  namespace fs = std::filesystem;
  const auto sync = [](const std::string& path, int flags) {
    const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
    if (descriptor < 0) return false;
    const bool done = ::fsync(descriptor) == 0;
    ::close(descriptor);
    return done;
  };
  std::error_code error;
  if (!sync(from, O_RDONLY))
    return fail(ErrorCode::io, to, "The new file could not be flushed to the disk.", "Check the disk, then save again.");
  for (const char* suffix : {"-wal", "-shm"}) fs::remove(to + suffix, error);  // log files of the replaced file
  fs::rename(from, to, error);
  if (error)
    return fail(ErrorCode::io, to, "The new file could not be renamed to its final name: " + error.message() + ".",
                "Check the folder's permissions, then save again.");
  const std::string folder = fs::path(to).parent_path().string();
  (void)sync(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY);
  return {};
}

/// Error `io` if the folder of a new file does not exist. SQLite resolves ".." in a path without looking at the folder before it.
Result<void> check_folder(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code error;
  if (folder.empty() || std::filesystem::is_directory(folder, error)) return {};
  return fail(ErrorCode::io, path, "The folder " + folder.string() + " does not exist.", "Create it first, or choose another folder.");
}

/// Writes a new project file without history. The file must not exist.
Result<void> write_new(const std::string& path, const std::string& document, const std::string& saved, std::uint64_t next_id,
                       const content::Resources& resources) {
  Result<ProjectFile> file = ProjectFile::create(path);
  if (!file) return fail(std::move(file.error()));
  return file->write([&]() -> Result<void> {
    for (const auto& [name, value] : {std::pair<const char*, std::string>("document", document),
                                      {"saved", saved},
                                      {"position", "0"},
                                      {"next_id", std::to_string(next_id)}})
      if (Result<void> done = file->set_property(name, value); !done) return done;
    for (const auto& [id, mechanism] : resources.mechanisms) {
      if (content::is_prop_mechanism(id)) continue;  // made from the document
      Result<void> done = file->put_resource(id, "mechanism", mechanism->name(), bytes_of(formats::write_mechanism(*mechanism)));
      if (!done) return done;
    }
    for (const auto& [id, motion] : resources.motions)
      if (Result<void> done = file->put_resource(id, "motion", motion->name, formats::write_motion(*motion)); !done) return done;
    return {};
  });
}

}  // namespace

struct Project::Body {
  // The lock is released after the file is closed: members are destroyed in reverse order.
  FileLock lock;
  ProjectFile file;
  bool read_only = false;
  content::Scenario scenario;
  std::string document, saved;
  content::Resources resources;
  content::Catalogue catalogue;
  std::vector<Step> steps;
  std::int64_t position = 0;  ///< number of the last history step that the document includes
  std::uint64_t next_id = 1, revision = 0;

  std::optional<Problem> lost;  ///< the file was lost: every edit is refused with this problem
  bool copied = false;          ///< true: save_as() has copied the work to another file

  Body(FileLock l, ProjectFile f) : lock(std::move(l)), file(std::move(f)) {}
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  ~Body() {
    if (read_only || lost) return;
    if (!copied && (revision > 0 || file.has_unmerged()))
      (void)check_file();  // if the file was lost, writes a rescue copy next to the project
    else if (file.lost())
      file.abandon();
  }

  /// Reads and checks the whole file.
  Result<void> read();
  Result<void> may_write() const {
    if (read_only) return fail(ErrorCode::conflict, file.path(), "The project was opened read-only.", "Open it for editing.");
    return {};
  }
  /// Runs `write` in one transaction.
  template <class Write>
  Result<void> in_transaction(Write write) {
    if (Result<void> allowed = may_write(); !allowed) return allowed;
    if (Result<void> good = check_file(); !good) return good;
    if (Result<void> done = file.write(write); !done) return done;
    return check_file();
  }
  /// Error `conflict` if another program replaced, removed or overwrote the file. The first such error saves a rescue copy and names it.
  Result<void> check_file();
  /// Writes the project to the empty file `path`: with its history if the open file can be read, otherwise from memory without it.
  Result<void> copy_to(const std::string& path, bool readable);
  Result<void> put(const Loaded& resource) { return file.put_resource(resource.id, resource.kind, resource.name, resource.data); }
  /// Adds the resource to the maps in memory.
  void add_to_maps(const Loaded& resource) {
    if (resource.mechanism) {
      catalogue.mechanisms.insert_or_assign(resource.id, content::facts_of(*resource.mechanism));
      resources.mechanisms.insert_or_assign(resource.id, resource.mechanism);
    } else {
      catalogue.motions.insert_or_assign(resource.id, content::facts_of(*resource.motion));
      resources.motions.insert_or_assign(resource.id, resource.motion);
    }
  }
  bool has(std::string_view id) const { return resources.mechanisms.contains(id) || resources.motions.contains(id); }
  Result<Loaded> fetch(std::string_view id, const store::Library& library) const {
    Result<store::LibraryEntry> entry = library.get(id);
    if (!entry) return fail(std::move(entry.error()));
    Result<std::vector<std::byte>> data = library.content(id);
    if (!data) return fail(std::move(data.error()));
    return load(id, store::name_of(entry->kind), std::move(*data), "library entry " + std::string(id));
  }
  std::ptrdiff_t step_index(std::int64_t number) const {
    const auto it = std::find_if(steps.begin(), steps.end(), [&](const Step& s) { return s.number == number; });
    return it == steps.end() ? -1 : it - steps.begin();
  }
  /// Undoes or redoes one step of the history. @return its label
  Result<std::string> step_history(bool back);
};

Result<void> Project::Body::read() {
  Result<std::vector<ResourceRow>> rows = file.resources();
  if (!rows) return fail(std::move(rows.error()));
  Error problems;
  for (ResourceRow& row : *rows) {
    Result<Loaded> resource = load(row.id, row.kind, std::move(row.data), file.path() + ", " + row.kind + " " + row.id);
    if (resource)
      add_to_maps(*resource);
    else
      for (Problem& p : resource.error().problems) problems.problems.push_back(std::move(p));
  }
  if (!problems.empty()) return fail(std::move(problems));
  for (const auto& [name, text] : {std::pair<const char*, std::string*>("document", &document), {"saved", &saved}}) {
    Result<std::string> value = file.property(name);
    if (!value) return fail(std::move(value.error()));
    *text = std::move(*value);
  }
  const std::string location = file.path() + ", scenario";
  Result<content::Scenario> read = content::read_scenario(document, location);
  if (!read) return fail(std::move(read.error()));
  problems = content::check_scenario(*read, &catalogue, location);
  if (!problems.empty()) return fail(std::move(problems));
  scenario = std::move(*read);
  content::add_props(scenario, resources);
  if (std::string canonical = content::write_scenario(scenario); canonical != document) {
    if (saved == document) saved = canonical;
    document = std::move(canonical);  // the file was written by another program or version in a non-canonical form
  }
  for (const auto& [name, is_position] : {std::pair<const char*, bool>("position", true), {"next_id", false}}) {
    const Result<std::string> text = file.property(name);
    if (!text) return fail(text.error());
    const std::optional<long> number = parse_long(*text);
    if (!number || *number < 0)
      return fail(ErrorCode::syntax, file.path(), "The property '" + std::string(name) + "' is not a number of at least 0.",
                  "Restore the project from a backup; the file was not changed.");
    if (is_position)
      position = *number;
    else
      next_id = static_cast<std::uint64_t>(*number);
  }
  Result<std::vector<Step>> all = file.steps();
  if (!all) return fail(std::move(all.error()));
  steps = std::move(*all);
  return {};
}

Result<void> Project::Body::copy_to(const std::string& path, bool readable) {
  if (readable) {
    Result<store::Statement> copy = file.database().prepare("VACUUM INTO ?1");
    Result<void> done = copy ? copy->bind(1, path).run() : fail(copy.error());
    if (!done) return done;
    const Result<Project> read = open_read_only(path);
    return read ? Result<void>() : fail(read.error());
  }
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  return write_new(path, document, saved, next_id, resources);
}

Result<void> Project::Body::check_file() {
  if (lost) return fail(*lost);
  const std::optional<Loss> loss = file.lost();
  if (!loss) return {};
  file.database().keep_log_when_closed();
  Result<std::string> rescue = fail(Error());
  if (loss->readable) rescue = store::make_rescue_copy(file.path(), [&](const std::string& copy) { return copy_to(copy, true); });
  if (!rescue) rescue = store::make_rescue_copy(file.path(), [&](const std::string& copy) { return copy_to(copy, false); });
  if (!rescue) {
    // `lost` stays empty, so that the next edit tries to write the copy: the cause (a full disk, for example) may be gone by then.
    return fail(ErrorCode::conflict, file.path(),
                loss->what + ". The edit was refused, and no rescue copy could be written: " + rescue.error().text(),
                "Save the project under another name before you close it.");
  }
  file.abandon();
  lost = Problem{ErrorCode::conflict, file.path(), loss->what + ". The edit was refused. Your work is in the rescue copy " + *rescue + ".",
                 "Open the rescue copy, or save the project under another name to continue."};
  return fail(*lost);
}

Project::Project(std::unique_ptr<Body> body) : body_(std::move(body)) {}
Project::Project(Project&&) noexcept = default;
Project& Project::operator=(Project&&) noexcept = default;
Project::~Project() = default;

Result<Project> Project::create(const std::string& path, const content::Scenario& scenario, const content::Resources& resources) {
  content::Scenario document = scenario;
  content::put_in_order(document);
  const content::Catalogue catalogue = content::catalogue_of(resources);
  Error problems = content::check_scenario(document, &catalogue);
  if (!problems.empty()) return fail(std::move(problems));
  if (Result<void> there = check_folder(path); !there) return fail(std::move(there.error()));
  Result<FileLock> lock = FileLock::take(path);
  if (!lock) return fail(std::move(lock.error()));
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored))
    return fail(ErrorCode::conflict, path, "The file exists already.", "Choose another name, or remove it first.");
  // The file is created under another name first, so that a file with the project's name is always a complete project.
  const std::string unfinished = path + ".new";
  for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(unfinished + suffix, ignored);
  const std::string text = content::write_scenario(document);
  Result<void> made = write_new(unfinished, text, text, 1, resources);
  if (made) made = move_into_place(unfinished, path);
  if (!made) {
    for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(unfinished + suffix, ignored);
    for (Problem& p : made.error().problems)
      if (p.location == unfinished) p.location = path;
    return fail(std::move(made.error()));
  }
  if (Result<void> done = lock->take_file(path); !done) return fail(std::move(done.error()));
  Result<ProjectFile> file = ProjectFile::open(path, false);
  if (!file) return fail(std::move(file.error()));
  auto body = std::make_unique<Body>(std::move(*lock), std::move(*file));
  if (Result<void> done = body->read(); !done) return fail(std::move(done.error()));
  return Project(std::move(body));
}

Result<Project> Project::open(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    Result<ProjectFile> missing = ProjectFile::open(path, true);
    if (!missing) return fail(std::move(missing.error()));
  }
  Result<FileLock> lock = FileLock::take(path);
  if (!lock) return fail(std::move(lock.error()));
  if (Result<void> done = lock->take_file(path); !done) return fail(std::move(done.error()));
  {
    Result<Project> look = open_read_only(path);  // opening for writing may change a file that must be refused
    if (!look) return fail(std::move(look.error()));
  }
  Result<ProjectFile> file = ProjectFile::open(path, false);
  if (!file) return fail(std::move(file.error()));
  auto body = std::make_unique<Body>(std::move(*lock), std::move(*file));
  if (Result<void> done = body->read(); !done) return fail(std::move(done.error()));
  return Project(std::move(body));
}

Result<Project> Project::open_read_only(const std::string& path) {
  Result<ProjectFile> file = ProjectFile::open(path, true);
  if (!file) return fail(std::move(file.error()));
  auto body = std::make_unique<Body>(FileLock(), std::move(*file));
  body->read_only = true;
  if (Result<void> done = body->read(); !done) return fail(std::move(done.error()));
  return Project(std::move(body));
}

const std::string& Project::path() const { return body_->file.path(); }
const std::optional<Problem>& Project::warning() const { return body_->file.warning(); }
const content::Scenario& Project::scenario() const { return body_->scenario; }
const std::string& Project::document() const { return body_->document; }
const content::Resources& Project::resources() const { return body_->resources; }
const content::Catalogue& Project::catalogue() const { return body_->catalogue; }
std::uint64_t Project::revision() const { return body_->revision; }

std::vector<std::string> Project::missing_resources(std::string_view command) const {
  std::vector<std::string> missing;
  for (const std::string& id : content::resources_named(command))
    if (!content::is_prop_mechanism(id) && !body_->has(id) && std::find(missing.begin(), missing.end(), id) == missing.end())
      missing.push_back(id);
  return missing;
}

Result<std::vector<LibraryData>> Project::fetch(std::span<const std::string> ids, const store::Library& library) {
  std::vector<LibraryData> out;
  for (const std::string& id : ids) {
    Result<store::LibraryEntry> entry = library.get(id);
    if (!entry) {
      if (entry.error().problems.front().code == ErrorCode::unknown) continue;  // the command's check reports the unknown id
      return fail(std::move(entry.error()));
    }
    Result<std::vector<std::byte>> data = library.content(id);
    if (!data) return fail(std::move(data.error()));
    out.push_back({id, std::string(store::name_of(entry->kind)), std::move(*data)});
  }
  return out;
}

Result<Change> Project::execute(std::string_view command, const store::Library* library) {
  if (Result<void> allowed = body_->may_write(); !allowed) return fail(std::move(allowed.error()));
  if (library == nullptr) return execute_with(command, {});
  const Result<std::vector<LibraryData>> data = fetch(missing_resources(command), *library);
  if (!data) return fail(data.error());
  return execute_with(command, *data);
}

Result<Change> Project::execute_with(std::string_view command, std::span<const LibraryData> from_library) {
  Body& b = *body_;
  if (Result<void> allowed = b.may_write(); !allowed) return fail(std::move(allowed.error()));
  std::vector<Loaded> fetched;
  content::Catalogue catalogue = b.catalogue;
  for (const LibraryData& entry : from_library) {
    const bool known = b.has(entry.id) || std::any_of(fetched.begin(), fetched.end(), [&](const Loaded& l) { return l.id == entry.id; });
    if (known) continue;
    Result<Loaded> resource = load(entry.id, entry.kind, entry.data, "library entry " + entry.id);
    if (!resource) return fail(std::move(resource.error()));
    if (resource->mechanism)
      catalogue.mechanisms.emplace(entry.id, content::facts_of(*resource->mechanism));
    else
      catalogue.motions.emplace(entry.id, content::facts_of(*resource->motion));
    fetched.push_back(std::move(*resource));
  }
  std::uint64_t next_id = b.next_id;
  Result<content::CommandEffect> effect = content::apply_command(b.scenario, command, catalogue, next_id);
  if (!effect) return fail(std::move(effect.error()));
  const std::string text = content::write_scenario(effect->scenario);
  if (text == b.document) return Change{};

  const Result<content::Json> before = content::parse_json(b.document, "document"), after = content::parse_json(text, "document");
  UGOKI_CHECK(before && after);
  const StepData step{effect->label, std::string(command), content::make_delta(*before, *after).dump(),
                      content::make_delta(*after, *before).dump()};
  Result<void> written = b.in_transaction([&]() -> Result<void> {
    for (const Loaded& resource : fetched)
      if (Result<void> done = b.put(resource); !done) return done;
    if (Result<void> done = b.file.add_step(b.position, step, max_history_steps); !done) return done;
    for (const auto& [name, value] : {std::pair<const char*, std::string>("document", text),
                                      {"position", std::to_string(b.position + 1)},
                                      {"next_id", std::to_string(next_id)}})
      if (Result<void> done = b.file.set_property(name, value); !done) return done;
    return {};
  });
  if (!written) return fail(std::move(written.error()));
  for (const Loaded& resource : fetched) b.add_to_maps(resource);
  const std::int64_t position = b.position;
  std::erase_if(b.steps, [&](const Step& s) { return s.number > position || s.number <= position + 1 - max_history_steps; });
  b.steps.push_back({++b.position, effect->label});
  b.next_id = next_id;
  b.scenario = std::move(effect->scenario);
  content::add_props(b.scenario, b.resources);
  b.document = text;
  ++b.revision;
  return Change{std::move(effect->label), std::move(effect->created)};
}

Result<std::string> Project::Body::step_history(bool back) {
  if (Result<void> allowed = may_write(); !allowed) return fail(std::move(allowed.error()));
  const std::int64_t number = back ? position : position + 1;
  if (step_index(number) < 0) return fail(ErrorCode::range, file.path(), back ? "There is nothing to undo." : "There is nothing to redo.");
  const Result<StepData> data = file.step(number);
  if (!data) return fail(data.error());
  const Result<content::Json> delta = content::parse_json(back ? data->backward : data->forward, file.path() + ", history");
  if (!delta) return fail(delta.error());
  const Result<content::Json> now = content::parse_json(document, "document");
  UGOKI_CHECK(now.has_value());
  const Result<content::Json> then = content::apply_delta(*now, *delta);
  if (!then) return fail(then.error());
  Result<content::Scenario> next = content::read_scenario(then->dump(), file.path() + ", history");
  if (!next) return fail(std::move(next.error()));
  Error problems = content::check_scenario(*next, &catalogue, file.path() + ", history");
  if (!problems.empty()) return fail(std::move(problems));
  const std::string text = content::write_scenario(*next);
  const std::int64_t target = back ? position - 1 : position + 1;
  Result<void> written = in_transaction([&]() -> Result<void> {
    if (Result<void> done = file.set_property("document", text); !done) return done;
    return file.set_property("position", std::to_string(target));
  });
  if (!written) return fail(std::move(written.error()));
  scenario = std::move(*next);
  content::add_props(scenario, resources);
  document = text;
  position = target;
  ++revision;
  return data->label;
}

Result<std::string> Project::undo() { return body_->step_history(true); }
Result<std::string> Project::redo() { return body_->step_history(false); }
bool Project::can_undo() const { return body_->step_index(body_->position) >= 0; }
bool Project::can_redo() const { return body_->step_index(body_->position + 1) >= 0; }
std::string Project::undo_label() const {
  const std::ptrdiff_t i = body_->step_index(body_->position);
  return i < 0 ? std::string() : body_->steps[static_cast<std::size_t>(i)].label;
}
std::string Project::redo_label() const {
  const std::ptrdiff_t i = body_->step_index(body_->position + 1);
  return i < 0 ? std::string() : body_->steps[static_cast<std::size_t>(i)].label;
}

bool Project::unsaved() const { return body_->document != body_->saved; }

Result<void> Project::save() {
  Body& b = *body_;
  if (Result<void> done = b.in_transaction([&] { return b.file.set_property("saved", b.document); }); !done) return done;
  b.saved = b.document;
  return b.file.database().run("PRAGMA wal_checkpoint(TRUNCATE)");  // merges the log, so that a user who copies the file needs no -wal file
}

Result<void> Project::save_as(const std::string& path, bool overwrite) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (fs::equivalent(path, this->path(), ignored)) return save();
  if (Result<void> there = check_folder(path); !there) return there;
  Result<FileLock> lock = FileLock::take(path);
  if (!lock) return fail(std::move(lock.error()));
  if (fs::exists(path, ignored) && !overwrite)
    return fail(ErrorCode::conflict, path, "The file exists already.", "Choose another name, or choose to replace the file.");
  const std::string unfinished = path + ".new";
  for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(unfinished + suffix, ignored);
  if (const int empty = ::open(unfinished.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600); empty >= 0) ::close(empty);
  const std::optional<Loss> loss = body_->file.lost();
  Result<void> made = body_->copy_to(unfinished, !loss || loss->readable);
  if (made) {
    Result<ProjectFile> file = ProjectFile::open(unfinished, false);
    made = file ? file->write([&] { return file->set_property("saved", body_->document); }) : fail(file.error());
  }
  if (const fs::file_status old = fs::status(path, ignored); made && fs::is_regular_file(old))
    fs::permissions(unfinished, old.permissions(), ignored);
  if (made) made = move_into_place(unfinished, path);
  if (!made) {
    for (const char* suffix : {"", "-wal", "-shm"}) fs::remove(unfinished + suffix, ignored);
    for (Problem& p : made.error().problems)
      if (p.location == unfinished || p.location == this->path()) p.location = path;  // the open project is not at fault
    return made;
  }
  if (Result<void> done = lock->take_file(path); !done) return done;
  Result<ProjectFile> file = ProjectFile::open(path, false);
  if (!file) return fail(std::move(file.error()));
  const std::uint64_t revision = body_->revision;
  auto body = std::make_unique<Body>(std::move(*lock), std::move(*file));
  if (Result<void> done = body->read(); !done) return done;
  body->revision = revision;
  body_->copied = true;
  body_ = std::move(body);
  return {};
}

Result<std::string> Project::kept(std::string_view name) const {
  Result<std::optional<std::string>> found = body_->file.find_property("kept/" + std::string(name));
  if (!found) return fail(std::move(found.error()));
  return std::move(*found).value_or("");
}

Result<void> Project::keep(std::string_view name, std::string_view text) {
  return body_->in_transaction([&] { return body_->file.set_property("kept/" + std::string(name), text); });
}

Result<void> Project::add_resource(std::string_view id, std::string_view kind, std::span<const std::byte> data) {
  if (body_->has(id)) return {};
  Result<Loaded> resource = load(id, kind, {data.begin(), data.end()}, std::string(kind) + " " + std::string(id));
  if (!resource) return fail(std::move(resource.error()));
  if (Result<void> done = body_->in_transaction([&] { return body_->put(*resource); }); !done) return done;
  body_->add_to_maps(*resource);
  return {};
}

Result<void> Project::adopt(std::string_view id, const store::Library& library) {
  if (body_->has(id)) return {};
  Result<Loaded> resource = body_->fetch(id, library);
  if (!resource) return fail(std::move(resource.error()));
  if (Result<void> done = body_->in_transaction([&] { return body_->put(*resource); }); !done) return done;
  body_->add_to_maps(*resource);
  return {};
}

Result<std::vector<std::byte>> Project::generate() const { return content::generate(body_->scenario, body_->resources); }

}  // namespace ugoki::project
