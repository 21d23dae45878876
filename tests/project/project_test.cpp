#include "ugoki/project/project.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <random>

#include "mesh_body.h"
#include "project_fixture.h"
#include "random_commands.h"
#include "ugoki/formats/motion_binary.h"

namespace ugoki::project {
namespace {

namespace fs = std::filesystem;
using content::testing::make_resources;
using content::testing::make_scenario;

/// Applies random commands until `count` of them have changed the document, some of them undone and done again in between. Then undoes all
/// and redoes all. Every state must have the bytes that it had before.
void check_random_history(Project project, std::size_t count, unsigned seed) {
  SCOPED_TRACE(seed);
  content::testing::RandomCommands random(seed);
  std::vector<std::uint64_t> states = {std::hash<std::string>{}(project.document())};
  const auto state = [&] { return std::hash<std::string>{}(project.document()); };
  constexpr int max_refused = 2000;  // in a row: more mean that the generator is in a dead end
  for (int refused = 0; states.size() <= count;) {
    const std::string command = random.next(project.scenario());
    const auto change = project.execute(command);
    if (!change || change->label.empty()) {
      ASSERT_LT(++refused, max_refused) << "in state " << states.size() << ": " << command << "\n"
                                         << (change ? "changes nothing" : change.error().text()) << "\n"
                                         << project.document();
      continue;
    }
    refused = 0;
    states.push_back(state());
    if (random.pick(6) != 0) continue;
    ASSERT_TRUE(project.undo());
    ASSERT_EQ(state(), states[states.size() - 2]) << "after undoing " << command;
    if (random.pick(2) == 0) {
      states.pop_back();
      continue;
    }
    ASSERT_TRUE(project.redo());
    ASSERT_EQ(state(), states.back()) << "after redoing " << command;
  }
  for (std::size_t i = states.size() - 1; i-- > 0;) {
    ASSERT_TRUE(project.undo());
    ASSERT_EQ(state(), states[i]) << "after undoing to state " << i;
  }
  EXPECT_FALSE(project.can_undo());
  for (std::size_t i = 1; i < states.size(); ++i) {
    ASSERT_TRUE(project.redo());
    ASSERT_EQ(state(), states[i]) << "after redoing to state " << i;
  }
  EXPECT_FALSE(project.can_redo());
}

/// In each round a child process applies commands and is killed at a random time. Every acknowledged command must be in the file
/// afterwards.
void kill_editors(const std::string& path, const std::function<void()>& make, int rounds, unsigned seed) {
  constexpr int rounds_per_project = 20;  // limits the history, because checking a round undoes all of it
  std::mt19937 random_time(seed);
  std::size_t count = 0;
  for (int round = 0; round < rounds; ++round) {
    if (round % rounds_per_project == 0) {
      for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(path + suffix);
      make();
    }
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      auto project = Project::open(path);
      content::testing::RandomCommands random(seed + static_cast<unsigned>(round));
      for (int i = 0; project; ++i) {
        if (i % 5 == 4)
          (void)project->undo();
        else if (i % 11 == 10)
          (void)project->save();
        else
          (void)project->execute(random.next(project->scenario()));
        const std::string& document = project->document();
        const std::uint64_t size = document.size();
        if (::write(ends[1], &size, sizeof size) != sizeof size || ::write(ends[1], document.data(), size) != static_cast<ssize_t>(size))
          break;
      }
      ::_exit(0);
    }
    ::close(ends[1]);
    std::vector<std::string> acknowledged;
    const auto receive = [&] {
      std::uint64_t size = 0;
      if (::read(ends[0], &size, sizeof size) != sizeof size) return false;
      std::string document(size, '\0');
      for (std::size_t got = 0; got < size;) {
        const ssize_t n = ::read(ends[0], document.data() + got, size - got);
        if (n <= 0) return false;
        got += static_cast<std::size_t>(n);
      }
      acknowledged.push_back(std::move(document));
      return true;
    };
    for (unsigned i = 0, n = 1 + static_cast<unsigned>(random_time() % 20); i < n && receive(); ++i) {
    }
    ::usleep(static_cast<useconds_t>(random_time() % 5000));
    ::kill(child, SIGKILL);
    while (receive()) {
    }
    ::close(ends[0]);
    ::waitpid(child, nullptr, 0);
    ASSERT_FALSE(acknowledged.empty());
    count += acknowledged.size();
    auto project = Project::open(path);
    ASSERT_TRUE(project) << project.error().text();
    // The child may have been killed after writing a change but before acknowledging it. One undo or redo then leads to the acknowledged
    // state.
    bool found = project->document() == acknowledged.back();
    if (!found && project->can_undo()) {
      ASSERT_TRUE(project->undo());
      found = project->document() == acknowledged.back();
      ASSERT_TRUE(project->redo());
    }
    if (!found && project->can_redo()) {
      ASSERT_TRUE(project->redo());
      found = project->document() == acknowledged.back();
    }
    EXPECT_TRUE(found) << "round " << round;
    if ((round + 1) % rounds_per_project != 0 && round + 1 != rounds) continue;
    while (project->can_undo()) ASSERT_TRUE(project->undo());
    while (project->can_redo()) ASSERT_TRUE(project->redo());
  }
  std::printf("%d kills, %zu commands acknowledged, seed %u\n", rounds, count, seed);
}

class ProjectTest : public ProjectFixture {
 protected:
  /// As make(), with a mesh body, from which props can be made.
  Project make_with_mesh() const {
    content::Resources resources = make_resources();
    resources.mechanisms["m-table"] = content::testing::body_of({{{-0.5, -0.5, 0}, {0.5, 0.5, 0.7}}});
    return Project::create(path_, make_scenario(), resources).value();
  }
};

TEST_F(ProjectTest, ReopenedProjectHasTheSameContent) {
  {
    const Project project = make();
    EXPECT_EQ(project.scenario(), make_scenario());
    EXPECT_FALSE(project.unsaved());
    EXPECT_FALSE(project.can_undo());
  }
  const auto project = Project::open(path_);
  ASSERT_TRUE(project) << project.error().text();
  EXPECT_EQ(project->scenario(), make_scenario());
  EXPECT_EQ(project->resources().motions.at("n-walk")->q, make_resources().motions.at("n-walk")->q);
  EXPECT_TRUE(project->generate());
  EXPECT_FALSE(Project::create(path_, make_scenario(), make_resources())) << "the file exists";
}

TEST_F(ProjectTest, MissingFolderIsNamed) {
  Project project = make();
  const std::string path = folder_ + "/none/../other.ugoki";
  const auto created = Project::create(path, make_scenario(), make_resources());
  ASSERT_FALSE(created);
  const auto saved = project.save_as(path, false);
  ASSERT_FALSE(saved);
  for (const Error* error : {&created.error(), &saved.error()})
    EXPECT_NE(error->text().find("/none/.. does not exist"), std::string::npos) << error->text();
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) files += entry.path().filename().string().starts_with("other");
  EXPECT_EQ(files, 0);
}

TEST_F(ProjectTest, CreatingAnInvalidProjectFails) {
  EXPECT_FALSE(Project::create(path_, make_scenario(), {}));
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_FALSE(Project::create(folder_ + "/no/such/folder.ugoki", content::Scenario()));
}

TEST_F(ProjectTest, UndoAndRedoSurviveRestarts) {
  std::string moved;
  {
    Project project = make();
    ASSERT_TRUE(project.execute(move_clip(4.5)));
    const auto change = project.execute(R"({"type": "clip.add", "character": "human", "motion": "n-walk", "start": 6.2})");
    ASSERT_TRUE(change) << change.error().text();
    EXPECT_EQ(change->label, "Add clip");
    EXPECT_EQ(change->created.size(), 1u);
    EXPECT_TRUE(project.unsaved());
    EXPECT_EQ(project.undo_label(), "Add clip");
    EXPECT_EQ(project.revision(), 2u);
  }
  {
    auto project = Project::open(path_);
    ASSERT_TRUE(project);
    EXPECT_TRUE(project->unsaved());
    EXPECT_EQ(project->undo_label(), "Add clip");
    EXPECT_EQ(*project->undo(), "Add clip");
    EXPECT_EQ(project->redo_label(), "Add clip");
    moved = project->document();
  }
  auto project = Project::open(path_);
  ASSERT_TRUE(project);
  EXPECT_EQ(project->document(), moved);
  EXPECT_TRUE(project->can_redo());
  ASSERT_TRUE(project->undo());
  EXPECT_EQ(project->scenario(), make_scenario());
  EXPECT_FALSE(project->unsaved()) << "the document equals the saved one again";
  EXPECT_FALSE(project->undo());
  ASSERT_TRUE(project->redo());
  EXPECT_EQ(project->document(), moved);
  ASSERT_TRUE(project->execute(move_clip(4.7)));
  EXPECT_FALSE(project->can_redo()) << "a new command discards the redo steps";
}

TEST_F(ProjectTest, CommandsWithoutEffectAddNoHistoryStep) {
  Project project = make();
  const auto change = project.execute(move_clip(5));
  ASSERT_TRUE(change) << change.error().text();
  EXPECT_TRUE(change->label.empty());
  EXPECT_FALSE(project.can_undo());
  EXPECT_EQ(project.revision(), 0u);
}

TEST_F(ProjectTest, RefusedCommandsChangeNothing) {
  Project project = make();
  const std::string before = project.document();
  EXPECT_FALSE(project.execute(move_clip(0)));
  EXPECT_FALSE(project.execute("not JSON"));
  EXPECT_EQ(project.document(), before);
  EXPECT_FALSE(project.can_undo());
}

TEST_F(ProjectTest, UndoAndRedoOfRandomEditsRestoreEveryState) { check_random_history(make_with_mesh(), 600, 1999); }

/// As many steps as a project keeps.
class SlowProjectTest : public ProjectTest {};
TEST_F(SlowProjectTest, UndoAndRedoOf10000RandomEditsRestoreEveryState) { check_random_history(make_with_mesh(), 10'000, 2026); }

TEST_F(ProjectTest, SavesAndSavesAs) {
  const std::string other = folder_ + "/copy.ugoki";
  Project project = make();
  ASSERT_TRUE(project.execute(move_clip(4.5)));
  ASSERT_TRUE(project.save());
  EXPECT_FALSE(project.unsaved());
  ASSERT_TRUE(project.execute(move_clip(4.6)));
  const std::string document = project.document();
  const auto saved = project.save_as(other);
  ASSERT_TRUE(saved) << saved.error().text();
  EXPECT_EQ(project.path(), other);
  EXPECT_FALSE(project.unsaved());
  EXPECT_EQ(project.document(), document);
  EXPECT_TRUE(project.can_undo()) << "the history is copied";
  auto old = Project::open(path_);
  ASSERT_TRUE(old) << "the old file is unlocked: " << old.error().text();
  EXPECT_EQ(old->document(), document) << "the old file is unchanged";
  EXPECT_TRUE(old->unsaved());
  EXPECT_FALSE(old->save_as(other)) << "the target is open";
  write(folder_ + "/taken.ugoki", "something");
  EXPECT_FALSE(old->save_as(folder_ + "/taken.ugoki"));
  EXPECT_EQ(read(folder_ + "/taken.ugoki"), "something");
  ASSERT_TRUE(old->save_as(folder_ + "/taken.ugoki", true));
  EXPECT_EQ(old->document(), document);
  EXPECT_FALSE(old->save_as(folder_ + "/no/folder/x.ugoki"));
  EXPECT_EQ(old->path(), folder_ + "/taken.ugoki");
}

TEST_F(ProjectTest, ClosingLeavesOnlyTheProjectFile) {
  {
    Project project = make();
    ASSERT_TRUE(project.execute(move_clip(4.5)));
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
  EXPECT_EQ(names, std::vector<std::string>{"park.ugoki"});
}

TEST_F(ProjectTest, OpeningTwiceIsAConflictThatNamesTheHolder) {
  const Project project = make();
  const auto again = Project::open(path_);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().problems.front().code, ErrorCode::conflict);
  EXPECT_NE(again.error().text().find(std::to_string(::getpid())), std::string::npos) << again.error().text();
  fs::create_symlink(path_, folder_ + "/alias.ugoki");
  EXPECT_FALSE(Project::open(folder_ + "/alias.ugoki")) << "a symbolic link to the same file";
  auto read_only = Project::open_read_only(path_);
  ASSERT_TRUE(read_only) << read_only.error().text();
  EXPECT_EQ(read_only->document(), project.document());
  EXPECT_FALSE(read_only->execute(move_clip(4.5)));
  EXPECT_FALSE(read_only->save());
}

TEST_F(ProjectTest, LockOfAnEndedProgramIsWaitedFor) {
  {
    const Project project = make();
  }
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t holder = ::fork();
  if (holder == 0) {
    const auto project = Project::open(path_);
    (void)!::write(ends[1], project ? "y" : "n", 1);
    if (::fork() == 0) ::usleep(300'000);  // us: a process that was being started when its parent was killed
    ::_exit(0);
  }
  char opened = 0;
  ASSERT_EQ(::read(ends[0], &opened, 1), 1);
  EXPECT_EQ(opened, 'y');
  ::close(ends[0]);
  ::close(ends[1]);
  ::waitpid(holder, nullptr, 0);
  const auto project = Project::open(path_);
  EXPECT_TRUE(project) << project.error().text();
}

TEST_F(ProjectTest, CommandFetchesItsResourcesFromTheLibrary) {
  auto library = store::Library::open(folder_ + "/library.db");
  ASSERT_TRUE(library);
  Motion motion = content::testing::make_walk("turn", 3, 1, 1.5, false);
  const std::vector<store::LibraryItem> items = {{store::EntryKind::motion, "turn", "{}", {}, formats::write_motion(motion)}};
  const std::string id = library->put(items)->front();
  const std::string command = R"({"type": "clip.add", "character": "human", "motion": ")" + id + R"(", "start": 6.5})";
  Project project = make();
  EXPECT_FALSE(project.execute(command)) << "the motion is only in the library";
  const auto change = project.execute(command, &*library);
  ASSERT_TRUE(change) << change.error().text();
  EXPECT_EQ(project.resources().motions.at(id)->q, motion.q);
  ASSERT_TRUE(project.undo());
  ASSERT_TRUE(project.redo()) << "the project keeps the motion after undo";
  const std::vector<store::LibraryItem> foreign = {{store::EntryKind::measured, "raw", "{}", {}, {std::byte(1)}}};
  const std::string measured = library->put(foreign)->front();
  EXPECT_FALSE(project.execute(R"({"type": "clip.add", "character": "human", "motion": ")" + measured + R"(", "start": 7})", &*library));
}

TEST_F(ProjectTest, KilledEditorLosesNothingAcknowledged) {
  kill_editors(path_, [this] { const Project project = make(); }, 6, 1);
}

class Slow_ProjectKillTest : public ProjectTest {};
TEST_F(Slow_ProjectKillTest, FiveHundredKillsLoseNothing) {
  kill_editors(path_, [this] { const Project project = make(); }, 500, 20260503);
}

}  // namespace
}  // namespace ugoki::project
