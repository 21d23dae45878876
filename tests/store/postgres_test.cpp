// Behaviour specific to PostgreSQL: passwords in addresses, lost connections, other schema versions, permissions.

#include <chrono>
#include <csignal>
#include <fstream>
#include <future>

#include "on_both.h"
#include "ugoki/store/connection.h"

namespace ugoki::store {
namespace {

TEST(PostgresAddress, PasswordsNeverAppearInMessages) {
  EXPECT_EQ(without_password("postgresql://anna:s3cret@host:5432/db?sslmode=require"), "postgresql://anna@host:5432/db?sslmode=require");
  EXPECT_EQ(without_password("postgres://anna@host/db"), "postgres://anna@host/db");
  EXPECT_EQ(without_password("postgresql://host/db?user=anna&password=s3cret&x=1"), "postgresql://host/db?user=anna&password=***&x=1");
  EXPECT_EQ(without_password("/home/a:b@c/library.db"), "/home/a:b@c/library.db");
  for (const char* address :
       {"postgresql://anna:s3cret@127.0.0.1:1/db", "postgresql://anna:s3cret@127.0.0.1:notaport/db",
        "postgresql://anna:s3cret@b@127.0.0.1:1/db", "postgresql://anna:a/s3cret@127.0.0.1:1/db",
        "postgresql://127.0.0.1:1/db?password=s3cret", "postgresql://127.0.0.1:1/db?password=a@s3cret",
        "postgresql://anna:%73s3cret@[::1/db", "postgresql://anna:s3cret@127.0.0.1:1/db?nonsense=1", "postgresql://:s3cret@127.0.0.1:1"}) {
    const auto refused = Library::open(address);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().text().find("s3cret"), std::string::npos) << refused.error().text();
    EXPECT_EQ(without_password(address).find("s3cret"), std::string::npos) << without_password(address);
    EXPECT_EQ(refused.error().problems.front().code, ErrorCode::io);
    EXPECT_FALSE(refused.error().problems.front().remedy.empty());
  }
}

class PostgresTest : public ::testing::Test {
 protected:
  void SetUp() override {
    server_ = PostgresServer::get();
    if (server_ == nullptr) GTEST_SKIP() << PostgresServer::unavailable_reason();
    location_ = server_->fresh_library();
  }
  PostgresServer* server_ = nullptr;
  std::string location_;
};

TEST_F(PostgresTest, LostConnectionIsRestoredAutomatically) {
  Result<Library> library = Library::open(location_);
  ASSERT_TRUE(library) << library.error().text();
  const auto id = library->put(std::vector{make_item(EntryKind::motion, "walk", "1")});
  ASSERT_TRUE(id);
  const std::string cut = "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE application_name = 'ugoki'";
  EXPECT_EQ(server_->psql(cut), "1");
  EXPECT_EQ(library->data(id->front()), bytes_of("1"));
  EXPECT_EQ(server_->psql(cut), "1");
  EXPECT_TRUE(library->put(std::vector{make_item(EntryKind::motion, "run", "2")}));
  server_->stop();
  const auto gone = library->put(std::vector{make_item(EntryKind::motion, "jump", "3")});
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().problems.front().code, ErrorCode::io) << gone.error().text();
  EXPECT_FALSE(gone.error().problems.front().remedy.empty());
  EXPECT_FALSE(library->find());
  ASSERT_TRUE(server_->start());
  EXPECT_EQ(names_of(library->find()), (std::vector<std::string>{"run", "walk"}));
  EXPECT_TRUE(library->put(std::vector{make_item(EntryKind::motion, "jump", "3")}));
  EXPECT_TRUE(library->check(false)->problems.empty());
}

/// Runs `work` while the server is frozen; thaws the server afterwards, or after 40 s. @return true if `work` ended before the server was
/// thawed
bool ends_while_frozen(const PostgresServer& server, const std::function<void()>& work) {
  server.freeze();
  std::future<void> running = std::async(std::launch::async, work);
  const bool ended = running.wait_for(std::chrono::seconds(40)) == std::future_status::ready;
  server.thaw();
  running.get();
  return ended;
}

TEST_F(PostgresTest, FrozenServerGivesAnErrorAndNothingIsLost) {
  Result<Library> library = Library::open(location_);
  ASSERT_TRUE(library) << library.error().text();
  const auto id = library->put(std::vector{make_item(EntryKind::motion, "walk", "1")});
  ASSERT_TRUE(id);
  const auto expect_refused = [](const auto& result) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().problems.front().code, ErrorCode::io);
    EXPECT_NE(result.error().text().find("does not respond"), std::string::npos) << result.error().text();
  };
  EXPECT_TRUE(ends_while_frozen(*server_, [&] { expect_refused(library->find()); })) << "a statement on an open connection";
  EXPECT_EQ(names_of(library->find()), std::vector<std::string>{"walk"});
  EXPECT_TRUE(ends_while_frozen(*server_, [&] { expect_refused(library->put(std::vector{make_item(EntryKind::motion, "run", "2")})); }));
  EXPECT_TRUE(ends_while_frozen(*server_, [&] { expect_refused(Library::open(location_)); })) << "a new connection";
  EXPECT_EQ(names_of(library->find()), std::vector<std::string>{"walk"}) << "a change that was refused is not stored";
  const std::string large(32 << 20, 'x');  // bytes; larger than the socket's buffers
  EXPECT_TRUE(ends_while_frozen(*server_, [&] { EXPECT_FALSE(library->put(std::vector{make_item(EntryKind::motion, "jump", large)})); }));
  EXPECT_TRUE(library->put(std::vector{make_item(EntryKind::motion, "jump", large)}));
  EXPECT_EQ(library->data(id->front()), bytes_of("1"));
  EXPECT_TRUE(library->check(false)->problems.empty());
}

TEST_F(PostgresTest, SlowStatementOnALiveServerIsNotInterrupted) {
  Result<std::unique_ptr<Connection>> connection = postgres_connection(location_, false);
  ASSERT_TRUE(connection) << connection.error().text();
  const Result<Rows> slow = (*connection)->query("SELECT 7::text FROM pg_sleep(8)");
  ASSERT_TRUE(slow) << slow.error().text();
  EXPECT_EQ(slow->text(0, 0), "7");
}

TEST_F(PostgresTest, NewerEmptyAndForbiddenDatabasesAreReported) {
  ASSERT_TRUE(Library::open(location_));
  EXPECT_EQ(server_->psql("UPDATE ugoki.library SET version = 99"), "");
  const auto newer = Library::open(location_);
  ASSERT_FALSE(newer);
  EXPECT_EQ(newer.error().problems.front().code, ErrorCode::unsupported) << newer.error().text();
  EXPECT_EQ(server_->psql("SET client_min_messages = error; DROP SCHEMA ugoki CASCADE"), "");
  const auto empty = Library::open_read_only(location_);
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().problems.front().code, ErrorCode::unknown) << empty.error().text();
  EXPECT_EQ(server_->psql("CREATE ROLE guest LOGIN"), "");
  const std::string as_guest = "postgresql://guest@" + location_.substr(location_.find("/postgres?"));
  const auto guest = Library::open(as_guest);
  ASSERT_FALSE(guest);
  EXPECT_NE(guest.error().text().find("right"), std::string::npos) << guest.error().text();
  EXPECT_EQ(server_->psql("DROP ROLE guest"), "");
  EXPECT_TRUE(Library::open(location_));
}

/// The SQL of the recipe for a team in docs/library.md, one statement a line.
std::string team_recipe() {
  std::ifstream page(UGOKI_DOCS "/library.md");
  std::string sql, line;
  bool in_recipe = false;
  while (std::getline(page, line)) {
    if (line == "```sql")
      in_recipe = true;
    else if (line == "```")
      in_recipe = false;
    else if (in_recipe)
      sql += line.substr(0, line.find("--")) + " ";
  }
  return sql;
}

TEST_F(PostgresTest, RolesOfATeamShareTheLibrary) {
  Result<Library> owner = Library::open(location_);
  ASSERT_TRUE(owner) << owner.error().text();
  ASSERT_TRUE(owner->put(std::vector{make_item(EntryKind::motion, "walk", "1")}));
  const auto as = [&](const std::string& role) { return "postgresql://" + role + "@" + location_.substr(location_.find("/postgres?")); };
  EXPECT_EQ(server_->psql("CREATE ROLE anna LOGIN; CREATE ROLE ben LOGIN; CREATE ROLE carla LOGIN"), "");
  const auto refused = Library::open(as("anna"));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("docs/library.md"), std::string::npos) << refused.error().text();
  const std::string recipe = team_recipe();
  ASSERT_FALSE(recipe.empty());
  EXPECT_EQ(server_->psql(recipe), "");

  Result<Library> anna = Library::open(as("anna")), ben = Library::open(as("ben"));
  ASSERT_TRUE(anna && ben) << (anna ? ben : anna).error().text();
  const auto made = anna->put(std::vector{make_item(EntryKind::motion, "run", "2", {"quick"})});
  ASSERT_TRUE(made) << made.error().text();
  const std::string id = made->front();
  ASSERT_TRUE(ben->save({.id = id, .base = 1, .name = "run fast"}));
  ASSERT_TRUE(ben->remove(id));
  ASSERT_TRUE(ben->undelete(id));
  ASSERT_TRUE(anna->set_tags(id, std::vector<std::string>{"loop"}, {}));
  EXPECT_EQ(names_of(anna->find()), (std::vector<std::string>{"run fast", "walk"}));
  EXPECT_TRUE(ben->check(true)->problems.empty());
  ASSERT_TRUE(anna->remove(id));
  EXPECT_EQ(anna->empty_trash(), 1u);
  EXPECT_TRUE(anna->collect_garbage());

  Result<Library> carla = Library::open(as("carla"));
  ASSERT_TRUE(carla) << carla.error().text();
  EXPECT_EQ(names_of(carla->find()), std::vector<std::string>{"walk"});
  const auto forbidden = carla->put(std::vector{make_item(EntryKind::motion, "jump", "3")});
  ASSERT_FALSE(forbidden);
  EXPECT_NE(forbidden.error().text().find("docs/library.md"), std::string::npos) << forbidden.error().text();
  for (Result<Library>* closed : {&anna, &ben, &carla}) *closed = fail(Error());
  EXPECT_EQ(
      server_->psql("DROP OWNED BY ugoki_team, ugoki_readers, anna, ben, carla; DROP ROLE ugoki_team, ugoki_readers, anna, ben, carla"),
      "");
}

TEST_F(PostgresTest, ChangesAreReportedAfterALostConnection) {
  Result<Library> library = Library::open(location_);
  ASSERT_TRUE(library);
  ASSERT_EQ(library->changed_elsewhere(), false);
  server_->stop();
  EXPECT_FALSE(library->changed_elsewhere());
  ASSERT_TRUE(server_->start());
  EXPECT_EQ(library->changed_elsewhere(), true) << "changes may have been missed";
  EXPECT_EQ(library->changed_elsewhere(), false);
}

TEST_F(PostgresTest, OlderLibraryIsUpgraded) {
  // SQL that turns the tables of the current version into those of older versions.
  const std::string version_2 = "DROP TABLE ugoki.entry_order; DROP FUNCTION ugoki.terms_of; UPDATE ugoki.library SET version = 2";
  const std::string version_3 =
      version_2 +
      "; ALTER TABLE ugoki.entry_text ADD id text NOT NULL DEFAULT '', ADD name_key text NOT NULL DEFAULT '', ADD "
      "changed text NOT NULL DEFAULT '', ADD duration_ms bigint NOT NULL DEFAULT 0; CREATE INDEX entry_text_terms "
      "ON ugoki.entry_text USING gin (terms); UPDATE ugoki.library SET version = 3";
  {
    Result<Library> library = Library::open(location_);
    ASSERT_TRUE(library);
    ASSERT_TRUE(library->put(std::vector{make_item(EntryKind::motion, "walk", "1", {}, R"({"duration": 2})"),
                                         make_item(EntryKind::motion, "walk far", "2", {}, R"({"duration": 9})")}));
  }
  for (const std::string& before : {version_2, version_3}) {
    EXPECT_EQ(server_->psql(before), "");
    const auto read_only = Library::open_read_only(location_);
    ASSERT_FALSE(read_only);
    EXPECT_EQ(read_only.error().problems.front().code, ErrorCode::unsupported) << read_only.error().text();
    Result<Library> library = Library::open(location_);
    ASSERT_TRUE(library) << library.error().text();
    EXPECT_EQ(names_of(library->find({.text = "walk", .order = LibraryOrder::longest})), (std::vector<std::string>{"walk far", "walk"}));
    EXPECT_EQ(names_of(library->find({.text = "walk_far"})), std::vector<std::string>{"walk far"}) << "the words must be adjacent";
    EXPECT_TRUE(library->check(false)->problems.empty());
    EXPECT_TRUE(Library::open_read_only(location_));
    EXPECT_EQ(server_->psql("UPDATE ugoki.entry_order SET duration_ms = 1"), "");
    EXPECT_EQ(library->check(false)->problems.problems.size(), 2u);
    EXPECT_TRUE(library->check(true)->problems.empty());
    const std::string id = library->find({.text = "far"})->entries.front().id;
    ASSERT_TRUE(library->rename(id, "walk farther"));
    EXPECT_EQ(library->find({.text = "farther"})->total, 1u) << "the search words are rebuilt";
    ASSERT_TRUE(library->rename(id, "walk far"));
    EXPECT_EQ(library->find({.text = "farther"})->total, 0u);
  }
}

}  // namespace
}  // namespace ugoki::store
