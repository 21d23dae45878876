#pragma once
// What a Library holds, for the files that make up its parts. Internal to store.

#include "ugoki/store/connection.h"
#include "ugoki/store/library.h"
#include "ugoki/store/library_rows.h"

namespace ugoki::store {

struct LibraryBody {
  std::unique_ptr<Connection> connection;
  std::string author;
  std::size_t few = counted_at_most;  ///< so many entries are found by the index and sorted; for more, find() reads in order

  [[nodiscard]] const std::string& place() const { return connection->place(); }
  [[nodiscard]] std::string place(std::string_view id) const { return place() + ", entry " + std::string(id); }
  [[nodiscard]] Result<std::string> now() const {
    const Result<Rows> rows = connection->query("SELECT " + connection->dialect().now);
    if (!rows) return fail(rows.error());
    return rows->text(0, 0);
  }

  /// Runs `work`, which returns a Result, wholly or not at all; again where another's work at the same time was in the way.
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

enum class Trash : std::uint8_t { no, yes, both };
/// The entry of this id, or the one with a version of this content.
[[nodiscard]] Result<EntryRow> find_entry(const LibraryBody& body, std::string_view id, Trash trash);
[[nodiscard]] std::unexpected<Error> no_entry(const LibraryBody& body, std::string_view id);
/// A problem unless the summary is a JSON object and the name is not empty.
[[nodiscard]] Result<void> check_item(const LibraryBody& body, std::string_view id, const std::string& name, const std::string& summary);
/// Whether a browser shows it: PNG, or WebP in its RIFF container.
[[nodiscard]] bool is_picture(std::span<const std::byte> bytes);

}  // namespace ugoki::store
