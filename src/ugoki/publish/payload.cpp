#include "ugoki/publish/payload.h"

#include <cstring>

#include "ugoki/base/hash.h"

namespace ugoki::publish {
namespace {

constexpr char magic[8] = {'U', 'G', 'O', 'K', 'I', 'E', 'X', 'E'};
constexpr std::size_t trailer_size = 64, alignment = 64;

void align(std::vector<std::byte>& bytes) { bytes.resize((bytes.size() + alignment - 1) / alignment * alignment); }

std::uint64_t hash_of(std::string_view page, std::span<const std::byte> ugx) {
  Hash64 hash;
  hash.add_bytes(page.data(), page.size());
  hash.add_bytes(ugx.data(), ugx.size());
  return hash.value();
}

template <class T>
T load(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

std::vector<std::byte> append_payload(std::span<const std::byte> program, std::string_view page, std::span<const std::byte> ugx) {
  std::vector<std::byte> out(program.begin(), program.end());
  align(out);
  const std::uint64_t page_at = out.size();
  const auto* p = reinterpret_cast<const std::byte*>(page.data());
  out.insert(out.end(), p, p + page.size());
  align(out);
  const std::uint64_t ugx_at = out.size();
  out.insert(out.end(), ugx.begin(), ugx.end());
  align(out);
  const std::size_t at = out.size();
  out.resize(at + trailer_size);
  const auto store = [&](std::size_t offset, auto value) { std::memcpy(out.data() + at + offset, &value, sizeof value); };
  std::memcpy(out.data() + at, magic, sizeof magic);
  store(8, payload_version);
  store(16, page_at);
  store(24, static_cast<std::uint64_t>(page.size()));
  store(32, ugx_at);
  store(40, static_cast<std::uint64_t>(ugx.size()));
  store(48, hash_of(page, ugx));
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
  const auto page_at = load<std::uint64_t>(trailer, 16), page_size = load<std::uint64_t>(trailer, 24);
  const auto ugx_at = load<std::uint64_t>(trailer, 32), ugx_size = load<std::uint64_t>(trailer, 40);
  if (page_at > room || page_size > room - page_at || ugx_at > room || ugx_size > room - ugx_at)
    return fail(ErrorCode::truncated, location, "The file is shorter than its content.", remedy);
  Payload out{{reinterpret_cast<const char*>(file.data()) + page_at, static_cast<std::size_t>(page_size)},
              file.subspan(static_cast<std::size_t>(ugx_at), static_cast<std::size_t>(ugx_size))};
  if (hash_of(out.page, out.ugx) != load<std::uint64_t>(trailer, 48))
    return fail(ErrorCode::syntax, location, "The content is damaged (checksum).", remedy);
  return out;
}

}  // namespace ugoki::publish
