#include "ugoki/publish/payload.h"

#include <cstring>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"

namespace ugoki::publish {
namespace {

constexpr char magic[8] = {'U', 'G', 'O', 'K', 'I', 'E', 'X', 'E'};
constexpr std::size_t trailer_size = 64, alignment = 64, name_size = 112, entry_size = 16 + name_size;
constexpr std::uint32_t max_libraries = 1000;

void align(std::vector<std::byte>& bytes) { bytes.resize((bytes.size() + alignment - 1) / alignment * alignment); }

std::uint64_t hash_of(std::string_view page, std::span<const std::byte> ugx, std::span<const CarriedLibrary> libraries) {
  Hash64 hash;
  hash.add_bytes(page.data(), page.size());
  hash.add_bytes(ugx.data(), ugx.size());
  for (const CarriedLibrary& each : libraries) {
    hash.add_bytes(each.name.data(), each.name.size());
    hash.add_bytes(each.bytes.data(), each.bytes.size());
  }
  return hash.value();
}

/// Whether a name can be used as the name of a file in a temporary folder.
bool is_file_name(std::string_view name) {
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._+-";
  return !name.empty() && name.size() < name_size && name.front() != '.' && name.find_first_not_of(letters) == std::string_view::npos;
}

template <class T>
T load(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

std::vector<std::byte> append_payload(std::span<const std::byte> program, std::string_view page, std::span<const std::byte> ugx,
                                      std::span<const CarriedLibrary> libraries) {
  std::vector<std::byte> out(program.begin(), program.end());
  const auto append = [&](std::span<const std::byte> bytes) {
    align(out);
    const std::uint64_t at = out.size();
    out.insert(out.end(), bytes.begin(), bytes.end());
    return at;
  };
  const auto store = [&](std::size_t at, auto value) { std::memcpy(out.data() + at, &value, sizeof value); };
  const std::uint64_t page_at = append(std::as_bytes(std::span(page)));
  const std::uint64_t ugx_at = append(ugx);
  std::vector<std::uint64_t> offsets;
  for (const CarriedLibrary& each : libraries) {
    UGOKI_CHECK(is_file_name(each.name));
    offsets.push_back(append(each.bytes));
  }
  align(out);
  const std::size_t table = out.size(), trailer = table + libraries.size() * entry_size;
  out.resize(trailer + trailer_size);
  for (std::size_t i = 0; i < libraries.size(); ++i) {
    const std::size_t entry = table + i * entry_size;
    store(entry, offsets[i]);
    store(entry + 8, static_cast<std::uint64_t>(libraries[i].bytes.size()));
    std::memcpy(out.data() + entry + 16, libraries[i].name.data(), libraries[i].name.size());
  }
  std::memcpy(out.data() + trailer, magic, sizeof magic);
  store(trailer + 8, payload_version);
  store(trailer + 12, static_cast<std::uint32_t>(libraries.size()));
  store(trailer + 16, page_at);
  store(trailer + 24, static_cast<std::uint64_t>(page.size()));
  store(trailer + 32, ugx_at);
  store(trailer + 40, static_cast<std::uint64_t>(ugx.size()));
  store(trailer + 48, hash_of(page, ugx, libraries));
  store(trailer + 56, static_cast<std::uint64_t>(table));
  return out;
}

Result<Payload> read_payload(std::span<const std::byte> file, std::string_view name) {
  const std::string location(name);
  const char* remedy = "Export it again with `ugoki export --native`.";
  if (file.size() < trailer_size || std::memcmp(file.data() + file.size() - trailer_size, magic, sizeof magic) != 0)
    return fail(ErrorCode::structure, location, "This program has no content.", remedy);
  const auto trailer = file.last(trailer_size);
  if (const auto version = load<std::uint32_t>(trailer, 8); version != payload_version)
    return fail(
        ErrorCode::unsupported, location,
        "The content has version " + std::to_string(version) + "; this program reads version " + std::to_string(payload_version) + ".",
        remedy);
  const std::uint64_t room = file.size() - trailer_size;
  bool complete = true;
  const auto part = [&](std::uint64_t at, std::uint64_t size) -> std::span<const std::byte> {
    complete = complete && at <= room && size <= room - at;
    if (!complete) return {};
    return file.subspan(static_cast<std::size_t>(at), static_cast<std::size_t>(size));
  };
  const std::span<const std::byte> page = part(load<std::uint64_t>(trailer, 16), load<std::uint64_t>(trailer, 24));
  Payload out;
  out.page = {reinterpret_cast<const char*>(page.data()), page.size()};
  out.ugx = part(load<std::uint64_t>(trailer, 32), load<std::uint64_t>(trailer, 40));
  const auto count = load<std::uint32_t>(trailer, 12);
  const std::span<const std::byte> table = part(load<std::uint64_t>(trailer, 56), std::uint64_t{count} * entry_size);
  bool sound = count <= max_libraries;
  for (std::uint32_t i = 0; complete && sound && i < count; ++i) {
    const auto entry = table.subspan(i * entry_size, entry_size);
    const auto* file_name = reinterpret_cast<const char*>(entry.data()) + 16;
    CarriedLibrary library{std::string(file_name, strnlen(file_name, name_size)),
                           part(load<std::uint64_t>(entry, 0), load<std::uint64_t>(entry, 8))};
    sound = is_file_name(library.name);
    out.libraries.push_back(std::move(library));
  }
  if (!complete) return fail(ErrorCode::truncated, location, "The file is shorter than its content.", remedy);
  if (!sound || hash_of(out.page, out.ugx, out.libraries) != load<std::uint64_t>(trailer, 48))
    return fail(ErrorCode::syntax, location, "The content is damaged (checksum).", remedy);
  return out;
}

}  // namespace ugoki::publish
