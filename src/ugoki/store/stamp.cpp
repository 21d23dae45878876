#include "ugoki/store/stamp.h"

#include <sys/random.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <thread>
#include <vector>

#include "ugoki/store/log_format.h"

namespace ugoki::store {
namespace {

constexpr std::string_view mark = "ugoki stamp";  // makes the row recognisable in a page

/// Reads the page `number`, counted from 1, of a database file. The result is shorter than a page at the end of the file.
std::vector<std::byte> read_page(std::ifstream& file, std::uint64_t number, std::uint32_t size) {
  std::vector<std::byte> page(size);
  file.clear();
  file.seekg(static_cast<std::streamoff>((number - 1) * size));
  file.read(reinterpret_cast<char*>(page.data()), static_cast<std::streamsize>(size));
  page.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  return page;
}

/// The stamp in the database file without its log. The pages are read directly, because a file whose log is merged partly, as after a
/// crash, is not a valid database without its log.
Result<std::optional<StampRow>> stamp_in_file(const std::string& path, const LogStamps& log) {
  std::ifstream file(path, std::ios::binary);
  for (const std::uint32_t page : log.pages)
    if (const std::optional<StampRow> row = stamp_on_page(read_page(file, page, log.page_size))) return row;
  if (!log.pages.empty()) return std::nullopt;
  // A log without stamps belongs to a file without stamps, or to another file.
  Result<Database> database = Database::open(path, OpenMode::main_file_only);
  if (!database) return fail(std::move(database.error()));
  if (Result<std::optional<StampRow>> row = read_stamp(*database); row) return row;
  for (std::uint64_t number = 1;; ++number) {
    const std::vector<std::byte> page = read_page(file, number, log.page_size);
    if (page.size() < log.page_size) return std::nullopt;
    if (const std::optional<StampRow> row = stamp_on_page(page)) return row;
  }
}

}  // namespace

LogStamps read_log(const std::string& path) {
  LogStamps out;
  std::ifstream file(path, std::ios::binary);
  std::optional<LogReader> log = LogReader::begin(file);
  if (!log) return out;
  out.page_size = log->page_size();
  std::vector<StampRow> uncommitted;
  while (const std::optional<LogFrame> frame = log->next()) {
    if (const std::optional<StampRow> row = stamp_on_page(log->page())) {
      uncommitted.push_back(*row);
      if (std::ranges::find(out.pages, frame->page_number) == out.pages.end()) out.pages.push_back(frame->page_number);
    }
    if (!frame->ends_transaction) continue;
    out.has_transactions = true;
    out.rows.insert(out.rows.end(), uncommitted.begin(), uncommitted.end());
    uncommitted.clear();
  }
  return out;
}

bool belongs(const std::optional<StampRow>& file, const LogStamps& log) {
  if (!log.has_transactions) return true;
  // The upgrade of a file without stamps writes the first stamp, whose previous stamp is zero.
  if (!file) return log.rows.empty() || log.rows.front().previous == Stamp{};
  if (log.rows.empty()) return false;
  return file->stamp == log.rows.front().previous ||
         std::any_of(log.rows.begin(), log.rows.end(), [&](const StampRow& row) { return row.stamp == file->stamp; });
}

Result<void> advance_stamp(Database& database) {
  Result<std::optional<StampRow>> now = read_stamp(database);
  if (!now) return fail(std::move(now.error()));
  std::array<std::byte, 32> value{};
  if (*now) std::copy((*now)->stamp.begin(), (*now)->stamp.end(), value.begin() + 16);
  if (::getrandom(value.data(), 16, 0) != 16)
    return fail(ErrorCode::io, database.path(), "The system returned no random number.", "Try again.");
  Result<Statement> put = database.prepare("INSERT OR REPLACE INTO stamp (number, mark, value) VALUES (1, ?1, ?2)");
  if (!put) return fail(std::move(put.error()));
  return put->bind(1, mark).bind_blob(2, value).run();
}

Result<void> ensure_stamp(Database& database) {
  const Result<std::optional<StampRow>> now = read_stamp(database);
  if (!now) return fail(now.error());
  if (*now) return {};
  Result<Transaction> transaction = Transaction::begin(database);
  if (!transaction) return fail(std::move(transaction.error()));
  if (Result<void> done = advance_stamp(database); !done) return done;
  return transaction->commit();
}

Result<std::optional<StampRow>> read_stamp(Database& database) {
  const Result<std::int64_t> tables = database.integer("SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = 'stamp'");
  if (!tables) return fail(tables.error());
  if (*tables == 0) return std::nullopt;
  Result<Statement> row = database.prepare("SELECT value FROM stamp WHERE number = 1");
  if (!row) return fail(std::move(row.error()));
  const Result<bool> found = row->step();
  if (!found) return fail(found.error());
  if (!*found) return std::nullopt;
  const std::vector<std::byte> value = row->blob(0);
  if (value.size() != 32) return std::nullopt;
  StampRow out;
  std::copy_n(value.begin(), 16, out.stamp.begin());
  std::copy_n(value.begin() + 16, 16, out.previous.begin());
  return out;
}

std::optional<StampRow> stamp_on_page(std::span<const std::byte> page) {
  // A table leaf with one cell. The cell: payload size, rowid 1, record header (size and three types, each one byte: NULL for the rowid
  // column, text, blob), mark, value. Source: https://www.sqlite.org/fileformat2.html#b_tree_pages
  constexpr std::size_t header = 4, size = header + mark.size() + 32;
  if (page.size() < 512 || page[0] != std::byte{0x0d} || page[3] != std::byte{0} || page[4] != std::byte{1}) return std::nullopt;
  const std::size_t cell = static_cast<std::size_t>(page[8]) << 8 | static_cast<std::size_t>(page[9]);
  if (cell + 2 + size > page.size()) return std::nullopt;
  const std::array<std::byte, 2 + header> expected = {
      std::byte{size}, std::byte{1}, std::byte{header}, std::byte{0}, std::byte{13 + 2 * mark.size()}, std::byte{12 + 2 * 32}};
  if (!std::equal(expected.begin(), expected.end(), page.begin() + static_cast<std::ptrdiff_t>(cell))) return std::nullopt;
  const std::span<const std::byte> text = page.subspan(cell + expected.size(), mark.size());
  if (std::memcmp(text.data(), mark.data(), mark.size()) != 0) return std::nullopt;
  const std::span<const std::byte> value = page.subspan(cell + expected.size() + mark.size(), 32);
  StampRow out;
  std::copy_n(value.begin(), 16, out.stamp.begin());
  std::copy_n(value.begin() + 16, 16, out.previous.begin());
  return out;
}

Result<void> check_log(const std::string& path) {
  const std::string log = path + "-wal";
  std::error_code missing;
  if (std::filesystem::file_size(log, missing) == 0 || missing) return {};
  // A program that edits the file may merge the log or begin it again between the reads. The comparison is then repeated.
  constexpr int max_attempts = 20;
  for (int attempt = 1;; ++attempt) {
    const LogStamps stamps = read_log(log);
    if (!stamps.has_transactions) return {};
    const Result<std::optional<StampRow>> in_file = stamp_in_file(path, stamps);
    if (in_file && belongs(*in_file, stamps)) return {};
    if (attempt < max_attempts) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      continue;
    }
    if (!in_file) return fail(in_file.error());
    return fail(ErrorCode::conflict, path,
                "The write-ahead log " + log +
                    " belongs to another database file: the file was replaced or restored after a crash or while it was open.",
                "To open the file as it is, move " + log + " and " + path +
                    "-shm to another folder; to recover the unmerged changes, restore the file that was replaced. Nothing was changed.");
  }
}

}  // namespace ugoki::store
