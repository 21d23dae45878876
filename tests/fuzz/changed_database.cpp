#include "changed_database.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <utility>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"
#include "ugoki/base/sha256.h"
#include "ugoki/store/library.h"
#include "ugoki/store/sqlite.h"

namespace ugoki {
namespace {

namespace fs = std::filesystem;

std::string_view next_word(std::string_view& line) {
  const std::size_t end = std::min(line.find(' '), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(std::min(end + 1, line.size()));
  return word;
}
bool is_identifier(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) { return (c >= 'a' && c <= 'z') || c == '_'; });
}

class Changes {
 public:
  explicit Changes(store::Database& database) : database_(database) {
    for (const char* sql : {"PRAGMA synchronous = OFF", "PRAGMA journal_mode = MEMORY", "PRAGMA ignore_check_constraints = ON", "BEGIN"})
      UGOKI_CHECK(database_.run(sql).has_value());
  }
  ~Changes() { (void)database_.run("COMMIT"); }
  Changes(const Changes&) = delete;
  Changes& operator=(const Changes&) = delete;

  /// Applies one change. @param line a change, see changed_database.h
  void make(std::string_view line) {
    const std::string_view first = next_word(line);
    if (first == "-") {
      const std::string_view table = next_word(line);
      return run("DELETE FROM " + std::string(table) + where(table, "?1"), {}, line);
    }
    const std::size_t dot = first.find('.');
    const std::string_view table = first.substr(0, dot), column = first.substr(dot + 1);
    const std::string_view key = next_word(line);
    if (first == "blob.bytes") return set_blob(key, line);
    const bool resource = first == "resource.data";
    const std::string also = resource ? ", checksum = '" + hash_of(line) + "'" : "";
    run("UPDATE " + std::string(table) + " SET " + std::string(column) + " = ?2" + also + where(table, "?1"), line, key, resource);
  }

 private:
  static std::string hash_of(std::string_view text) {
    Hash64 hash;
    hash.add_bytes(text.data(), text.size());
    return hash.hex();
  }
  static std::string where(std::string_view table, const std::string& key) {
    return table == "property" ? " WHERE name = " + key : " WHERE rowid = " + key;
  }
  /// Runs a statement. A change that the database refuses has no effect.
  void run(const std::string& sql, std::string_view value, std::string_view key, bool blob = false) {
    auto statement = database_.prepare(sql);
    if (!statement) return;
    statement->bind(1, key);
    if (sql.find("?2") != std::string::npos) blob ? statement->bind_blob(2, bytes_of(value)) : statement->bind(2, value);
    (void)statement->run();
  }
  /// Replaces the data of a blob, and the blob's hash in every table that refers to the blob.
  void set_blob(std::string_view key, std::string_view value) {
    const std::string number(key.substr(0, 9)), hash = sha256(bytes_of(value));
    if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) return;
    const auto old = database_.text("SELECT hash FROM blob WHERE rowid = " + number);
    if (!old || old->empty()) return;
    run("UPDATE blob SET bytes = ?2 WHERE rowid = ?1", value, key, true);
    run("UPDATE blob SET hash = ?2, size = " + std::to_string(value.size()) + " WHERE rowid = ?1", hash, key);
    for (const store::EntryKind kind : store::entry_kinds) {
      const std::string content = store::entry_id(kind, bytes_of(value)), of_kind(store::name_of(kind));
      for (const char* table : {"version", "entry"})
        run("UPDATE " + std::string(table) + " SET data = ?2, content = '" + content + "', size = " + std::to_string(value.size()) +
                " WHERE data = ?1 AND " + (std::string_view(table) == "entry" ? "kind" : "(SELECT kind FROM entry WHERE no = entry)") +
                " = '" + of_kind + "'",
            hash, *old);
    }
  }

  store::Database& database_;
};

/// Whether a line is a valid change (syntax: changed_database.h).
bool is_change(std::string_view line) {
  const std::string_view first = next_word(line);
  if (first == "-") return is_identifier(next_word(line));
  const std::size_t dot = first.find('.');
  return dot != std::string_view::npos && is_identifier(first.substr(0, dot)) && is_identifier(first.substr(dot + 1));
}

void change_rows(const std::string& path, const std::vector<std::string_view>& lines) {
  auto database = store::Database::open(path, store::OpenMode::read_write);
  UGOKI_CHECK(database.has_value());
  Changes changes(*database);
  for (const std::string_view line : lines) changes.make(line);
}

}  // namespace

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  return {p, p + text.size()};
}

Folder::Folder() {
  const fs::path root = fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
  path_ = (root / "ugoki-fuzz-XXXXXX").string();
  UGOKI_CHECK(::mkdtemp(path_.data()) != nullptr);
}
Folder::~Folder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}
void Folder::clear() const {
  for (const auto& e : fs::directory_iterator(path_)) fs::remove(e.path());
}

std::string read_all(const std::string& path) {
  std::string bytes(fs::file_size(path), '\0');
  std::ifstream(path, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}
void write_all(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}
void into_one_file(const std::string& path) {
  auto database = store::Database::open(path, store::OpenMode::read_write);
  UGOKI_CHECK(database && database->run("PRAGMA journal_mode = DELETE"));
}

bool make_changed(const std::string& good, std::string_view input, const std::string& path) {
  std::vector<std::string_view> changes;
  std::vector<std::pair<std::size_t, std::string_view>> patches;
  for (int count = 0; !input.empty() && count < 100; ++count) {
    const std::size_t end = std::min(input.find('\n'), input.size());
    std::string_view line = input.substr(0, end);
    input.remove_prefix(std::min(end + 1, input.size()));
    if (!line.starts_with("@ ")) {
      if (is_change(line)) changes.push_back(line);
      continue;
    }
    line.remove_prefix(2);
    const std::string_view number = next_word(line);
    std::size_t offset = 0;
    std::from_chars(number.data(), number.data() + number.size(), offset);
    if (!line.empty()) patches.emplace_back(offset, line);
  }
  std::string bytes = good;
  if (!changes.empty()) {
    write_all(path, good);
    change_rows(path, changes);
    bytes = read_all(path);
  }
  for (const auto& [offset, patch] : patches) {
    const std::size_t at = offset % bytes.size();
    bytes.replace(at, std::min(patch.size(), bytes.size() - at), patch.substr(0, bytes.size() - at));
  }
  if (changes.empty() || !patches.empty()) write_all(path, bytes);
  return bytes != good;
}

}  // namespace ugoki
