#include "ugoki/store/log_damage.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "ugoki/store/log_format.h"
#include "ugoki/store/rescue.h"

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

/// True if a frame with this first salt was written before SQLite began the log again (or after it, while the log was read). SQLite adds
/// 1 to the first salt when it begins a log again.
bool is_other_generation(std::uint32_t salt, std::uint32_t salt_of_log) {
  constexpr std::uint32_t max_restarts = 1u << 20;
  const std::uint32_t before = salt_of_log - salt, after = salt - salt_of_log;
  return before != 0 && (before < max_restarts || after < max_restarts);
}

std::string words_of(const LogDamage& damage) {
  switch (damage.transactions) {
    case 0: return "changes behind it";
    case 1: return "the last change";
    default: return "the last " + std::to_string(damage.transactions) + " changes";
  }
}

}  // namespace

std::optional<LogDamage> find_log_damage(const std::string& log) {
  std::ifstream file(log, std::ios::binary);
  std::optional<LogReader> reader = LogReader::begin(file);
  if (!reader) {
    std::error_code missing;
    const std::uintmax_t size = fs::file_size(log, missing);
    if (missing || size < log_header_size + log_frame_header_size + min_page_size) return std::nullopt;  // no complete frame
    return LogDamage{};
  }
  while (reader->next()) {
  }
  // The frame at which the readable part ends, and all frames behind it.
  LogDamage damage{.offset = reader->offset()};
  bool damaged = false, first = true;
  while (const std::optional<LogFrame> frame = reader->next_unchecked()) {
    if (frame->of_this_log) {
      if (frame->ends_transaction) ++damage.transactions;
    } else if (first && !frame->is_zero && !is_other_generation(frame->salt, reader->salt())) {
      damaged = true;
    }
    first = false;
  }
  if (damage.transactions > 0) damaged = true;
  return damaged ? std::optional(damage) : std::nullopt;
}

Result<std::optional<Problem>> check_log_damage(const std::string& path, DamagedLog handling) {
  const std::string log = path + "-wal";
  std::optional<LogDamage> damage = find_log_damage(log);
  // A program that writes the log while it is read makes it look damaged. Real damage remains.
  constexpr int confirmations = 3;
  for (int i = 0; damage && i < confirmations; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (find_log_damage(log) != damage) damage.reset();
  }
  if (!damage) return std::optional<Problem>();
  Problem warning{ErrorCode::truncated, path,
                  "The write-ahead log " + log + " is damaged at byte " + std::to_string(damage->offset) + ": " + words_of(*damage) +
                      " cannot be read.",
                  "Restore the file and its log from a backup if the changes are needed."};
  if (handling == DamagedLog::report) return std::optional(std::move(warning));
  const Result<std::string> copy = make_rescue_copy(path, [&](const std::string& to) -> Result<void> {
    std::error_code error;
    fs::copy_file(path, to, fs::copy_options::overwrite_existing, error);
    if (!error) fs::copy_file(log, to + "-wal", error);
    if (error) return fail(ErrorCode::io, to, "The copy could not be written (" + error.message() + ").", "Check the disk.");
    return {};
  });
  if (!copy)
    return fail(ErrorCode::io, path, warning.message + " No copy of the damaged log could be made: " + copy.error().text(),
                "Copy the file and its log to another folder, then open it there. Nothing was changed.");
  warning.message += " A copy of the file and its log is kept: " + *copy + " and " + *copy + "-wal.";
  return std::optional(std::move(warning));
}

}  // namespace ugoki::store
