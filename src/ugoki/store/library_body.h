#pragma once
// The private members of Library, shared by the files that implement it. Internal to store.

#include "ugoki/store/connection.h"
#include "ugoki/store/library.h"
#include "ugoki/store/library_rows.h"

namespace ugoki::store {

struct LibraryBody {
  std::unique_ptr<Connection> connection;
  std::string author;
  std::optional<Problem> warning;  ///< see Library::warning()
  /// Maximum number of matches of the search index that find() sorts; see library_search.cpp. Tests set a small value.
  std::size_t sort_limit = max_counted;

  /// Location of the library, or of one of its entries, for messages.
  [[nodiscard]] const std::string& location() const { return connection->location(); }
  [[nodiscard]] std::string location(std::string_view id) const { return location() + ", entry " + std::string(id); }
  /// Current UTC time of the database.
  [[nodiscard]] Result<std::string> now() const {
    const Result<Rows> rows = connection->query("SELECT " + connection->dialect().now);
    if (!rows) return fail(rows.error());
    return rows->text(0, 0);
  }

  /// Runs `work`, which returns a Result, in one write transaction: committed if it succeeds, rolled back if it fails. Repeats the
  /// transaction, at most 8 times in total, after a conflict with a concurrent transaction.
  template <class Work>
  auto in_transaction(Work work) const -> decltype(work()) {
    constexpr int attempts = 8;
    for (int attempt = 1;; ++attempt) {
      if (Result<void> begun = connection->begin(Connection::Access::write); !begun) return fail(std::move(begun.error()));
      auto result = work();
      bool retry = !result && connection->should_retry();
      if (result) {
        Result<void> done = connection->commit();
        if (done) return result;
        retry = connection->should_retry();
        result = fail(std::move(done.error()));
      }
      connection->rollback();
      if (!retry || attempt == attempts) return result;
    }
  }
};

[[nodiscard]] LibraryBody& body_of(const Library& library);
[[nodiscard]] Result<LibraryEntry> public_entry(const EntryRow& row);

/// Entries to find: those that are not in the trash, those in the trash, or both.
enum class Trash : std::uint8_t { no, yes, both };
/// The entry with the id `id`, or else an entry with a version whose content id is `id`. @param trash whether to search the trash
[[nodiscard]] Result<EntryRow> find_entry(const LibraryBody& body, std::string_view id, Trash trash);
/// The error "the library has no entry `id`".
[[nodiscard]] std::unexpected<Error> no_entry(const LibraryBody& body, std::string_view id);
/// Checks that the summary is a JSON object and that the name is not empty.
[[nodiscard]] Result<void> check_item(const LibraryBody& body, std::string_view id, const std::string& name, const std::string& summary);
/// True if the bytes begin like a PNG file or a WebP file (in a RIFF container). The rest of the file is not checked.
[[nodiscard]] bool is_picture(std::span<const std::byte> bytes);

}  // namespace ugoki::store
