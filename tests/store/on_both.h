#pragma once
// Fixture of tests that run on both databases, SQLite and PostgreSQL. Each test begins with an empty library.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "postgres_server.h"
#include "ugoki/store/library.h"

namespace ugoki::store {

inline std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  return {p, p + text.size()};
}
/// An item for Library::put(), with the bytes of `data` as its data.
inline LibraryItem make_item(EntryKind kind, std::string name, std::string_view data, std::vector<std::string> tags = {},
                             std::string summary = "{}") {
  return {kind, std::move(name), std::move(summary), std::move(tags), bytes_of(data), {}};
}
/// The names of the entries of a page; the error's text if there is no page.
inline std::vector<std::string> names_of(const Result<LibraryPage>& page) {
  std::vector<std::string> out;
  if (!page) out.push_back(page.error().text());
  if (page)
    for (const LibraryEntry& e : page->entries) out.push_back(e.name);
  return out;
}

/// A new folder, deleted with its contents by the destructor.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    path_ = (std::filesystem::temp_directory_path() / "ugoki-store-XXXXXX").string();
    if (::mkdtemp(path_.data()) == nullptr) std::abort();
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

enum class DatabaseKind { sqlite, postgres };
inline std::string name_of_database(const ::testing::TestParamInfo<DatabaseKind>& info) {
  return info.param == DatabaseKind::sqlite ? "SQLite" : "PostgreSQL";
}

/// A test of the library at `location_`, which open() opens for writing. Skipped for PostgreSQL if it is not installed.
class OnBoth : public ::testing::TestWithParam<DatabaseKind> {
 protected:
  void SetUp() override {
    if (GetParam() == DatabaseKind::sqlite) {
      location_ = folder_.path() + "/deep/library.db";
      return;
    }
    PostgresServer* server = PostgresServer::get();
    if (server == nullptr) GTEST_SKIP() << PostgresServer::unavailable_reason();
    location_ = server->fresh_library();
  }
  [[nodiscard]] static bool on_postgres() { return GetParam() == DatabaseKind::postgres; }
  [[nodiscard]] Library open() const {
    Result<Library> library = Library::open(location_);
    if (!library) ADD_FAILURE() << library.error().text();
    return std::move(*library);
  }

  TemporaryFolder folder_;
  std::string location_;
};

#define UGOKI_ON_BOTH(Suite) \
  INSTANTIATE_TEST_SUITE_P(Databases, Suite, ::testing::Values(DatabaseKind::sqlite, DatabaseKind::postgres), name_of_database)

}  // namespace ugoki::store
