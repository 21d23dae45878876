// Exported sets, copies between libraries, and migration between the databases.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "on_both.h"
#include "ugoki/store/copy.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

/// The whole content of a library as one text: entries, versions, data and trash.
std::string dump(const Library& library) {
  std::string out;
  for (const bool removed : {false, true}) {
    const auto page = library.find({.removed = removed});
    if (!page) return page.error().text();
    for (const LibraryEntry& e : page->entries) {
      out += e.id + "|" + e.name + "|" + e.summary + "|" + e.note + "|" + e.created + "|" + e.changed + "|" + e.author + "|" + e.removed +
             e.removed_by + "|";
      for (const std::string& tag : e.tags) out += tag + ",";
      const auto picture = library.thumbnail(e.id);
      if (picture) out += std::to_string(picture->size());
      const auto history = library.history(e.id);
      if (!history) return history.error().text();
      for (const LibraryVersion& v : *history) {
        const auto data = library.content(v.content);
        out += "\n  " + std::to_string(v.version) + v.name + v.summary + v.note + v.content + v.author + v.saved + std::to_string(v.size);
        out += data ? " " + std::string(reinterpret_cast<const char*>(data->data()), data->size()) : data.error().text();
      }
      out += "\n";
    }
  }
  return out;
}

class CopyTest : public OnBoth {
 protected:
  std::string other_file() const { return folder_.path() + "/other.db"; }
  /// Adds four entries with versions, tags and a thumbnail, one of them in the trash. @return ids: body, walk, run
  static std::vector<std::string> fill(Library& library) {
    library.set_author("anna");
    const std::string body = library.put(std::vector{make_item(EntryKind::mechanism, "body", "B", {"human"})})->front();
    const std::string summary = R"({"duration": 2, "mechanism": ")" + body + "\"}";
    const auto ids =
        library.put(std::vector{make_item(EntryKind::motion, "walk", "W1", {"cmu", "slow"}, summary),
                                make_item(EntryKind::motion, "run", "R1", {"cmu"}), make_item(EntryKind::motion, "gone", "G")});
    EXPECT_TRUE(library.save({.id = (*ids)[0], .base = 1, .name = "stroll", .data = bytes_of("W2")}));
    EXPECT_TRUE(library.set_thumbnail((*ids)[0], bytes_of("\x89PNG\r\n\x1a\n")));
    EXPECT_TRUE(library.remove((*ids)[2]));
    return {body, (*ids)[0], (*ids)[1]};
  }
};
UGOKI_ON_BOTH(CopyTest);

TEST_P(CopyTest, CopyingALibraryThereAndBackChangesNothing) {
  Library here = open();
  fill(here);
  Result<Library> there = Library::open(other_file());
  ASSERT_TRUE(there);
  const auto report = copy_entries(here, *there);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->added, 4u);
  EXPECT_EQ(report->versions, 5u);
  EXPECT_EQ(dump(*there), dump(here));
  EXPECT_TRUE(there->check(false)->problems.empty()) << there->check(false)->problems.text();
  EXPECT_EQ(names_of(there->find({.text = "cmu strol"})), std::vector<std::string>{"stroll"});
  const auto again = copy_entries(here, *there);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->added + again->versions + again->blobs + again->continued, 0u);
  EXPECT_EQ(again->equal, 4u);
  // A copy to the other kind of database and back changes nothing.
  if (PostgresServer* server = PostgresServer::get(); server != nullptr && !on_postgres()) {
    Result<Library> team = Library::open(server->fresh_library());
    ASSERT_TRUE(team && copy_entries(here, *team));
    EXPECT_EQ(dump(*team), dump(here));
    Result<Library> back = Library::open(folder_.path() + "/back.db");
    ASSERT_TRUE(back && copy_entries(*team, *back));
    EXPECT_EQ(dump(*back), dump(here));
  }
}

TEST_P(CopyTest, StoppedCopyContinuesWhenRepeated) {
  Library here = open();
  std::vector<LibraryItem> items;
  for (int i = 0; i < 1000; ++i) items.push_back(make_item(EntryKind::motion, "m" + std::to_string(i), std::to_string(i)));
  ASSERT_TRUE(here.put(items));
  Result<Library> there = Library::open(other_file());
  ASSERT_TRUE(there);
  CopyOptions options;
  double reached = 0;
  options.progress = [&](double done) { reached = done; };
  options.stop = [&] { return reached >= 0.5; };
  const auto stopped = copy_entries(here, *there, options);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().problems.front().code, ErrorCode::cancelled);
  const std::size_t half = *there->count(EntryKind::motion);
  EXPECT_GE(half, 500u);
  EXPECT_LT(half, 1000u);
  options.stop = {};
  const auto rest = copy_entries(here, *there, options);
  ASSERT_TRUE(rest) << rest.error().text();
  EXPECT_EQ(rest->added, 1000u - half);
  EXPECT_EQ(rest->equal, half);
  EXPECT_EQ(dump(*there), dump(here));
}

TEST_P(CopyTest, AddsNewerVersionsAndNeverOverwritesDifferences) {
  Library here = open();
  const std::vector<std::string> ids = fill(here);
  Result<Library> there = Library::open(other_file());
  ASSERT_TRUE(there && copy_entries(here, *there));
  // The entry that is newer in the source is updated in the target. The entry that is newer in the target is unchanged.
  ASSERT_TRUE(here.save({.id = ids[1], .base = 2, .data = bytes_of("W3")}));
  ASSERT_TRUE(there->save({.id = ids[2], .base = 1, .data = bytes_of("R2")}));
  const auto report = copy_entries(here, *there);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->continued, 1u);
  EXPECT_EQ(report->equal, 3u);
  EXPECT_EQ(there->data(ids[1]), bytes_of("W3"));
  EXPECT_EQ(there->data(ids[2]), bytes_of("R2"));
  EXPECT_FALSE(there->get(ids[1])->thumbnail);
  // An entry changed in both libraries is reported and not copied. With the option save_differing its newest version is added.
  ASSERT_TRUE(here.save({.id = ids[2], .base = 1, .data = bytes_of("R2 of here")}));
  const auto left = copy_entries(here, *there);
  ASSERT_TRUE(left);
  ASSERT_EQ(left->differing.size(), 1u);
  EXPECT_NE(left->differing[0].find(ids[2]), std::string::npos);
  EXPECT_EQ(there->data(ids[2]), bytes_of("R2"));
  CopyOptions on_top;
  on_top.save_differing = true;
  const auto saved = copy_entries(here, *there, on_top);
  ASSERT_TRUE(saved) << saved.error().text();
  EXPECT_EQ(saved->saved, 1u);
  EXPECT_EQ(there->data(ids[2]), bytes_of("R2 of here"));
  EXPECT_EQ(there->data(ids[2], 2), bytes_of("R2"));
  EXPECT_EQ(there->get(ids[2])->version, 3);
  EXPECT_EQ(copy_entries(here, *there, on_top)->saved, 0u) << "a repeated copy adds nothing";
  EXPECT_TRUE(there->check(false)->problems.empty()) << there->check(false)->problems.text();
}

TEST_P(CopyTest, PartsOfKilledExportsAreRemoved) {
  Library here = open();
  const std::vector<std::string> ids = fill(here);
  const pid_t ended = ::fork();
  if (ended == 0) ::_exit(0);
  ::waitpid(ended, nullptr, 0);
  const std::string file = folder_.path() + "/walks.ugoki-set", part = file + ".part-";
  const std::string left = part + std::to_string(ended), used = part + std::to_string(::getppid()), other = part + "x";
  for (const std::string& path : {left, left + "-journal", used, other}) std::ofstream(path) << "x";
  ASSERT_TRUE(export_set(here, {ids[1]}, file));
  EXPECT_FALSE(std::filesystem::exists(left));
  EXPECT_FALSE(std::filesystem::exists(left + "-journal"));
  EXPECT_TRUE(std::filesystem::exists(used)) << "its process still runs";
  EXPECT_TRUE(std::filesystem::exists(other));
}

TEST_P(CopyTest, ExportedSetIncludesReferencedEntries) {
  Library here = open();
  const std::vector<std::string> ids = fill(here);
  const std::string file = folder_.path() + "/walks.ugoki-set";
  const auto exported = export_set(here, {ids[1]}, file);
  ASSERT_TRUE(exported) << exported.error().text();
  EXPECT_EQ(exported->added, 2u) << "the motion and its mechanism";
  EXPECT_EQ(exported->versions, 3u);
  for (const auto& entry : fs::directory_iterator(folder_.path()))
    EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
  {
    const auto set = Library::open_read_only(file);
    ASSERT_TRUE(set) << set.error().text();
    Result<Library> there = Library::open(other_file());
    ASSERT_TRUE(there && copy_entries(*set, *there));
    EXPECT_EQ(there->data(ids[1]), bytes_of("W2"));
    EXPECT_EQ(there->data(ids[1], 1), bytes_of("W1"));
    EXPECT_EQ(there->data(ids[0]), bytes_of("B"));
    EXPECT_TRUE(there->get(ids[1])->thumbnail);
    EXPECT_FALSE(there->get(ids[2]));
  }
  const std::string list = "[\"" + ids[1] + "\", \"" + ids[2] + "\"]";
  const auto set = here.put(std::vector{make_item(EntryKind::set, "both", list)});
  ASSERT_TRUE(set);
  CopyOptions latest;
  latest.latest_only = true;
  const auto all = export_set(here, {set->front()}, file, latest);
  ASSERT_TRUE(all) << all.error().text();
  EXPECT_EQ(all->added, 4u);
  EXPECT_EQ(all->versions, 4u);
  const auto only = Library::open_read_only(file);
  ASSERT_TRUE(only);
  EXPECT_EQ(only->get(ids[1])->version, 2);
  EXPECT_FALSE(only->data(ids[1], 1));
  EXPECT_TRUE(only->check(false)->problems.empty()) << only->check(false)->problems.text();
  EXPECT_FALSE(export_set(here, {"m-none"}, file));
  EXPECT_FALSE(export_set(here, {ids[0]}, "/nowhere/at/all/x.ugoki-set"));
}

TEST_P(CopyTest, DamagedDataAreNotCopied) {
  Library here = open();
  const std::vector<std::string> ids = fill(here);
  if (on_postgres()) {
    EXPECT_EQ(PostgresServer::get()->psql("UPDATE ugoki.blob SET bytes = 'x' WHERE bytes = 'R1'"), "");
  } else {
    auto database = Database::open(location_, OpenMode::read_write);
    ASSERT_TRUE(database && database->run("UPDATE blob SET bytes = x'00' WHERE bytes = CAST('R1' AS BLOB)"));
  }
  Result<Library> there = Library::open(other_file());
  ASSERT_TRUE(there);
  const auto refused = copy_entries(here, *there);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find(ids[2]), std::string::npos) << refused.error().text();
}

TEST_P(CopyTest, HostileSetIsRefusedAndChangesNothing) {
  const std::string good = folder_.path() + "/good.db", bad = folder_.path() + "/bad.db";
  {
    Result<Library> library = Library::open(other_file());
    ASSERT_TRUE(library);
    const std::vector<std::string> ids = fill(*library);
    ASSERT_TRUE(export_set(*library, {ids[1]}, good));
  }
  // Each change makes the set invalid. The motion has two versions.
  const char* changes[] = {
      "UPDATE entry SET kind = 'poison' WHERE id LIKE 'n-%'",
      "UPDATE entry SET kind = 'circuit' WHERE id LIKE 'n-%'",
      "UPDATE entry SET id = '../../etc/passwd' WHERE id LIKE 'n-%'",
      "UPDATE entry SET id = 'n-0123456789ABCDEF' WHERE id LIKE 'n-%'",
      "UPDATE entry SET name = 'another' WHERE id LIKE 'n-%'",
      "UPDATE entry SET summary = '[]' WHERE id LIKE 'n-%'; UPDATE version SET summary = '[]' WHERE version = 2",
      "UPDATE version SET summary = '{' WHERE version = 1",
      "UPDATE version SET name = '' WHERE version = 1",
      "UPDATE version SET note = 'a' || char(0) || 'b' WHERE version = 1",
      "UPDATE version SET author = CAST(x'ff41' AS TEXT) WHERE version = 1",
      "UPDATE version SET version = -1 WHERE version = 1",
      "UPDATE version SET version = 2147483647 WHERE version = 2; UPDATE entry SET version = 2147483647 WHERE version = 2",
      "UPDATE version SET size = 1000000 WHERE version = 1",
      "UPDATE version SET content = 'n-0123456789abcdef' WHERE version = 1",
      "UPDATE version SET data = (SELECT data FROM entry WHERE id LIKE 'm-%') WHERE version = 1",
      "UPDATE entry SET thumbnail = data WHERE id LIKE 'n-%'",
      "UPDATE entry SET created = '' WHERE id LIKE 'n-%'",
      "UPDATE tag SET tag = char(7) WHERE tag = 'slow'",
      "DELETE FROM version WHERE version = 2",
  };
  Library to = open();
  for (const char* change : changes) {
    SCOPED_TRACE(change);
    fs::copy_file(good, bad, fs::copy_options::overwrite_existing);
    {
      auto database = Database::open(bad, OpenMode::read_write);
      ASSERT_TRUE(database && database->run("PRAGMA ignore_check_constraints = ON"));
      const auto changed = database->run(change);
      ASSERT_TRUE(changed) << changed.error().text();
    }
    const Result<Library> from = Library::open_read_only(bad);
    ASSERT_TRUE(from);
    const auto refused = copy_entries(*from, to);
    ASSERT_FALSE(refused);
    for (const Problem& p : refused.error().problems) EXPECT_FALSE(p.location.empty() || p.message.empty() || p.remedy.empty()) << p.text();
    EXPECT_TRUE(names_of(to.find()).empty()) << "no entry may be copied";
    const auto check = to.check(false);
    ASSERT_TRUE(check);
    EXPECT_TRUE(check->problems.empty()) << check->problems.text();
  }
  const Result<Library> from = Library::open_read_only(good);
  ASSERT_TRUE(from && copy_entries(*from, to));
  EXPECT_EQ(names_of(to.find()), (std::vector<std::string>{"body", "stroll"}));
}

}  // namespace
}  // namespace ugoki::store
