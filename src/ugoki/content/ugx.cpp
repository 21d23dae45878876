#include "ugoki/content/ugx.h"

#include <cstring>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"

namespace ugoki::content {
namespace {

constexpr char magic[8] = {'U', 'G', 'O', 'K', 'I', 'U', 'G', 'X'};
constexpr std::size_t header_size = 64, entry_size = 64, name_size = 32, alignment = 64;

std::size_t aligned(std::size_t offset) { return (offset + alignment - 1) / alignment * alignment; }

template <class T>
T load(std::span<const std::byte> file, std::size_t offset) {
  T value;
  std::memcpy(&value, file.data() + offset, sizeof value);
  return value;
}
template <class T>
void store(std::vector<std::byte>& file, std::size_t offset, T value) {
  std::memcpy(file.data() + offset, &value, sizeof value);
}
std::uint64_t checksum(std::span<const std::byte> bytes) {
  Hash64 hash;
  hash.add_bytes(bytes.data(), bytes.size());
  return hash.value();
}

}  // namespace

const UgxSection* Ugx::find(std::string_view name) const {
  for (const UgxSection& s : sections_)
    if (s.name == name) return &s;
  return nullptr;
}

Result<Ugx> read_ugx(std::span<const std::byte> file) {
  const char* regenerate = "Generate the file again from its project.";
  if (file.size() < header_size)
    return fail(ErrorCode::truncated, "executable data", "The file is too short to hold a header.", regenerate);
  if (std::memcmp(file.data(), magic, sizeof magic) != 0)
    return fail(ErrorCode::syntax, "executable data", "The file is not Ugoki executable data (*.ugx).",
                "Give a file made by the generator.");
  const auto version = load<std::uint32_t>(file, 8);
  if (version != ugx_version)
    return fail(ErrorCode::unsupported, "executable data",
                "The file has version " + std::to_string(version) + "; this program reads version " + std::to_string(ugx_version) + ".",
                "Generate the file again from its project, or use a newer Ugoki.");
  const auto count = static_cast<std::size_t>(load<std::uint32_t>(file, 12));
  const auto size = load<std::uint64_t>(file, 16);
  if (size != file.size())
    return fail(ErrorCode::truncated, "executable data",
                "The file has " + std::to_string(file.size()) + " bytes, but its header specifies " + std::to_string(size) + ".",
                regenerate);
  if (count > (file.size() - header_size) / entry_size)
    return fail(ErrorCode::truncated, "executable data/sections", "The section table does not fit into the file.", regenerate);
  if (checksum(file.subspan(header_size, count * entry_size)) != load<std::uint64_t>(file, 24))
    return fail(ErrorCode::syntax, "executable data/sections", "The section table is damaged (checksum).", regenerate);

  Ugx ugx;
  Error problems;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = header_size + i * entry_size;
    char name[name_size + 1] = {};
    std::memcpy(name, file.data() + at, name_size);
    const std::string location = "executable data/" + std::string(name);
    const auto offset = load<std::uint64_t>(file, at + name_size);
    const auto bytes = load<std::uint64_t>(file, at + name_size + 8);
    if (offset % alignment != 0 || offset > file.size() || bytes > file.size() - offset) {
      problems.add(ErrorCode::truncated, location, "The section extends beyond the end of the file.", regenerate);
      continue;
    }
    const auto content = file.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes));
    if (checksum(content) != load<std::uint64_t>(file, at + name_size + 16)) {
      problems.add(ErrorCode::syntax, location, "The section is damaged (checksum).", regenerate);
      continue;
    }
    if (ugx.find(name)) {
      problems.add(ErrorCode::duplicate, location, "Two sections have the same name.", regenerate);
      continue;
    }
    ugx.sections_.push_back({name, content});
  }
  if (!problems.empty()) return fail(std::move(problems));
  return ugx;
}

void UgxWriter::add(std::string name, std::vector<std::byte> bytes) {
  UGOKI_CHECK(!name.empty() && name.size() < name_size);
  for (const Entry& e : entries_) UGOKI_CHECK(e.name != name);
  entries_.push_back({std::move(name), std::move(bytes)});
}

void UgxWriter::add(std::string name, std::string_view text) {
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  add(std::move(name), std::vector<std::byte>(p, p + text.size()));
}

std::vector<std::byte> UgxWriter::finish() const {
  std::size_t size = header_size + entries_.size() * entry_size;
  for (const Entry& e : entries_) size = aligned(size) + e.bytes.size();
  std::vector<std::byte> file(size);
  std::memcpy(file.data(), magic, sizeof magic);
  store(file, 8, ugx_version);
  store(file, 12, static_cast<std::uint32_t>(entries_.size()));
  store(file, 16, static_cast<std::uint64_t>(size));
  std::size_t offset = header_size + entries_.size() * entry_size;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry& e = entries_[i];
    const std::size_t at = header_size + i * entry_size;
    offset = aligned(offset);
    std::memcpy(file.data() + at, e.name.data(), e.name.size());
    store(file, at + name_size, static_cast<std::uint64_t>(offset));
    store(file, at + name_size + 8, static_cast<std::uint64_t>(e.bytes.size()));
    store(file, at + name_size + 16, checksum(e.bytes));
    if (!e.bytes.empty()) std::memcpy(file.data() + offset, e.bytes.data(), e.bytes.size());
    offset += e.bytes.size();
  }
  store(file, 24, checksum(std::span<const std::byte>(file).subspan(header_size, entries_.size() * entry_size)));
  return file;
}

}  // namespace ugoki::content
