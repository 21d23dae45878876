#include "ugoki/fmi/archive.h"

#include <sys/stat.h>
#include <zip.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <map>

namespace ugoki::fmi {
namespace {

// Bounds against zip bombs.
constexpr std::uint64_t max_bytes = std::uint64_t{2} << 30;     // maximum unpacked size of all entries together
constexpr std::uint64_t max_ratio = 100;                        // maximum ratio of unpacked to packed size, for entries above small_bytes
constexpr std::uint64_t small_bytes = std::uint64_t{32} << 20;  // entries up to this size may have any ratio
constexpr zip_int64_t max_entries = 100'000;

/// True for relative names that stay in the folder into which the zip is unpacked, on every operating system: no "..", '\\' or drive.
bool is_safe_name(std::string_view name) {
  if (name.empty() || name.size() > 1000 || name.front() == '/' ||
      name.find_first_of(std::string_view("\\:\0", 3)) != std::string_view::npos)
    return false;
  for (std::size_t at = 0; at <= name.size();) {
    const std::size_t end = std::min(name.find('/', at), name.size());
    const std::string_view part = name.substr(at, end - at);
    if (part == ".." || part == "." || (part.empty() && end != name.size()) || part.size() > 250) return false;
    at = end + 1;
  }
  return true;
}

std::string text_of(zip_error_t& error) {
  std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

/// Deleter for the handles of libzip.
struct Closer {
  void operator()(zip_t* zip) const { zip_discard(zip); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

}  // namespace

bool is_zip(std::string_view bytes) { return bytes.starts_with("PK\x03\x04") || bytes.starts_with("PK\x05\x06"); }

struct Archive::Body {
  std::string bytes, location;
  std::unique_ptr<zip_t, Closer> zip;
  std::vector<ArchiveEntry> entries;
  std::map<std::string, zip_uint64_t, std::less<>> index;
};

Archive::Archive(std::unique_ptr<Body> body) : body_(std::move(body)) {}
Archive::Archive(Archive&&) noexcept = default;
Archive& Archive::operator=(Archive&&) noexcept = default;
Archive::~Archive() = default;

const std::vector<ArchiveEntry>& Archive::entries() const { return body_->entries; }
bool Archive::has(std::string_view name) const { return body_->index.find(name) != body_->index.end(); }

Result<Archive> Archive::open(std::string bytes, std::string_view location) {
  auto body = std::make_unique<Body>();
  Body& b = *body;
  b.location = location;
  b.bytes = std::move(bytes);
  if (!is_zip(b.bytes))
    return fail(ErrorCode::syntax, b.location, "The file is not a zip, so it is not an FMU.", "Choose a file that was exported as an FMU.");
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(b.bytes.data(), b.bytes.size(), 0, &error);
  b.zip.reset(source ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr);
  if (!b.zip) {
    if (source) zip_source_free(source);
    return fail(ErrorCode::syntax, b.location, "The file is not a zip, or is truncated or damaged: " + text_of(error) + ".",
                "Get the FMU again.");
  }
  zip_error_fini(&error);
  const zip_int64_t count = zip_get_num_entries(b.zip.get(), 0);
  if (count < 0 || count > max_entries)
    return fail(ErrorCode::range, b.location,
                "The zip has " + std::to_string(count) + " entries; the limit is " + std::to_string(max_entries) + ".",
                "Export a smaller FMU.");
  std::uint64_t unpacked = 0;
  for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i) {
    zip_stat_t stat;
    const char* raw = zip_get_name(b.zip.get(), i, 0);
    if (!raw || zip_stat_index(b.zip.get(), i, 0, &stat) != 0 || (stat.valid & ZIP_STAT_SIZE) == 0 ||
        (stat.valid & ZIP_STAT_COMP_SIZE) == 0)
      return fail(ErrorCode::syntax, b.location, "Entry " + std::to_string(i) + " of the zip is damaged.", "Get the FMU again.");
    const std::string name = raw;
    if (!is_safe_name(name))
      return fail(ErrorCode::structure, b.location, "The zip has an entry '" + name.substr(0, 200) + "', whose name leads out of the zip.",
                  "Do not trust this file; get the FMU from its author.");
    if ((stat.valid & ZIP_STAT_ENCRYPTION_METHOD) != 0 && stat.encryption_method != ZIP_EM_NONE)
      return fail(ErrorCode::unsupported, b.location, "'" + name + "' is encrypted.", "Export the FMU without a password.");
    zip_uint8_t system = 0;
    zip_uint32_t attributes = 0;
    if (zip_file_get_external_attributes(b.zip.get(), i, 0, &system, &attributes) == 0 && system == ZIP_OPSYS_UNIX) {
      const mode_t kind = (attributes >> 16) & S_IFMT;
      if (kind != 0 && kind != S_IFREG && kind != S_IFDIR)
        return fail(ErrorCode::structure, b.location, "'" + name + "' is a link or a device, not a file.", "Export the FMU without links.");
    }
    if (name.back() == '/') continue;
    unpacked += std::min<std::uint64_t>(stat.size, max_bytes + 1);
    if (unpacked > max_bytes || (stat.size > small_bytes && stat.size / max_ratio > stat.comp_size))
      return fail(ErrorCode::range, b.location,
                  "'" + name + "' unpacks to " + std::to_string(stat.size) +
                      " bytes: more than 100 times its packed size, or more than 2 GiB together with the other files.",
                  "Export a smaller FMU.");
    if (!b.index.emplace(name, i).second)
      return fail(ErrorCode::duplicate, b.location, "The zip has two entries '" + name + "'.", "Get the FMU again.");
    b.entries.push_back({name, stat.size});
  }
  std::sort(b.entries.begin(), b.entries.end(), [](const ArchiveEntry& a, const ArchiveEntry& c) { return a.name < c.name; });
  return Archive(std::move(body));
}

Result<std::string> Archive::read(std::string_view name) const {
  const auto found = body_->index.find(name);
  if (found == body_->index.end())
    return fail(ErrorCode::unknown, body_->location, "The zip has no '" + std::string(name) + "'.", "Get the FMU again.");
  const auto entry = std::find_if(body_->entries.begin(), body_->entries.end(), [&](const ArchiveEntry& e) { return e.name == name; });
  const auto damaged = [&](const std::string& why) {
    return fail(ErrorCode::truncated, body_->location, "'" + std::string(name) + "' in the zip cannot be unpacked: " + why + ".",
                "Get the FMU again.");
  };
  const std::unique_ptr<zip_file_t, Closer> file(zip_fopen_index(body_->zip.get(), found->second, 0));
  if (!file) return damaged(zip_strerror(body_->zip.get()));
  std::string out;
  char buffer[1 << 16];
  while (true) {  // the size in the zip may be false: grow with the data that is really read
    const zip_int64_t n = zip_fread(file.get(), buffer, sizeof buffer);
    if (n < 0) return damaged(zip_file_strerror(file.get()));
    if (n == 0) break;
    out.append(buffer, static_cast<std::size_t>(n));
    if (out.size() > entry->bytes) return damaged("it is larger than the zip states");
  }
  if (out.size() != entry->bytes) return damaged("it is shorter than the zip states");
  return out;
}

Result<std::string> write_archive(const std::vector<std::pair<std::string, std::string>>& files, std::string_view location) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* target = zip_source_buffer_create(nullptr, 0, 0, &error);
  zip_t* zip = target ? zip_open_from_source(target, ZIP_CREATE | ZIP_TRUNCATE, &error) : nullptr;
  const auto failed = [&](const std::string& why) {
    return fail(ErrorCode::io, std::string(location), "The zip cannot be written: " + why + ".", "Close other programs and export again.");
  };
  if (!zip) {
    if (target) zip_source_free(target);
    return failed(text_of(error));
  }
  zip_error_fini(&error);
  zip_source_keep(target);
  std::tm day{};  // 2000-01-01 for all files, so that equal files give equal bytes
  day.tm_year = 100;
  day.tm_mday = 1;
  day.tm_isdst = -1;
  const time_t moment = std::mktime(&day);
  bool good = true;
  for (const auto& [name, bytes] : files) {
    zip_source_t* source = zip_source_buffer(zip, bytes.data(), bytes.size(), 0);
    const zip_int64_t i = source ? zip_file_add(zip, name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (source && i < 0) zip_source_free(source);
    good = good && i >= 0;
    if (i < 0) continue;
    const auto index = static_cast<zip_uint64_t>(i);
    const zip_uint32_t mode = name.ends_with(".so") ? S_IFREG | 0755 : S_IFREG | 0644;
    zip_set_file_compression(zip, index, ZIP_CM_DEFLATE, 1);
    zip_file_set_mtime(zip, index, moment, 0);
    zip_file_set_external_attributes(zip, index, 0, ZIP_OPSYS_UNIX, mode << 16);
  }
  std::string why = good ? "" : zip_strerror(zip);
  if (!good || zip_close(zip) != 0) {
    if (why.empty()) why = zip_strerror(zip);
    zip_discard(zip);
    zip_source_free(target);
    return failed(why);
  }
  zip_stat_t stat;
  std::string out;
  good = zip_source_stat(target, &stat) == 0 && zip_source_open(target) == 0;
  if (good) {
    out.resize(stat.size);
    good = zip_source_read(target, out.data(), out.size()) == static_cast<zip_int64_t>(out.size());
    zip_source_close(target);
  }
  zip_source_free(target);
  if (!good) return failed("not enough memory");
  return out;
}

}  // namespace ugoki::fmi
