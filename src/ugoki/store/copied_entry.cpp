#include "ugoki/store/copied_entry.h"

#include <algorithm>
#include <limits>

#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

std::unexpected<Error> invalid(const LibraryBody& from, const EntryRow& entry, std::string sentence) {
  return fail(ErrorCode::structure, from.location(clean_text(entry.id)), std::move(sentence),
              "Nothing of this entry was copied. Run `ugoki db check` on the library that it comes from, or request the set again.");
}

bool is_id_of(const std::string& text, EntryKind kind) {
  return text.size() == 18 && text.starts_with(entry_id(kind, {}).substr(0, 2)) &&
         text.find_first_not_of("0123456789abcdef", 2) == std::string::npos;
}

bool is_clean(std::initializer_list<std::string_view> texts) {
  return std::ranges::all_of(texts, [](std::string_view text) { return clean_text(text) == text; });
}

}  // namespace

Result<void> check_copied(const LibraryBody& from, const EntryRow& entry, const std::vector<VersionRow>& versions) {
  if (versions.empty()) return invalid(from, entry, "The entry has no version.");
  const Result<EntryKind> kind = entry_kind_named(entry.kind);
  if (!kind) return invalid(from, entry, "The kind of the entry is unknown to this program.");
  if (!is_id_of(entry.id, *kind)) return invalid(from, entry, "The id of the entry is not a valid id of kind " + entry.kind + ".");
  if (!is_clean({entry.created, entry.changed, entry.removed, entry.removed_by}) || entry.created.empty() || entry.changed.empty())
    return invalid(from, entry, "A time stamp of the entry is missing or invalid.");
  for (const std::string& tag : entry.tags)
    if (tag.empty() || !is_clean({tag})) return invalid(from, entry, "A tag of the entry is empty or contains invalid characters.");
  std::int64_t before = 0;
  for (const VersionRow& v : versions) {
    if (v.version <= before || v.version >= std::numeric_limits<int>::max())
      return invalid(from, entry, "The version numbers of the entry are not positive and increasing.");
    before = v.version;
    if (Result<void> good = check_item(from, entry.id, v.name, v.summary); !good) return good;
    if (!is_clean({v.name, v.summary, v.note, v.author, v.saved}))
      return invalid(from, entry, "Version " + std::to_string(v.version) + " of the entry contains invalid characters.");
    if (!is_id_of(v.content, *kind))
      return invalid(from, entry, "Version " + std::to_string(v.version) + " of the entry has no valid content id.");
  }
  if (entry.newest != versions.back()) return invalid(from, entry, "The entry differs from its newest version.");
  return {};
}

Result<void> check_copied_data(const LibraryBody& from, const EntryRow& entry, const VersionRow& version, std::span<const std::byte> data) {
  const Result<EntryKind> kind = entry_kind_named(entry.kind);
  if (!kind) return fail(kind.error());
  if (version.size == static_cast<std::int64_t>(data.size()) && version.content == entry_id(*kind, data)) return {};
  return invalid(from, entry,
                 "The data of version " + std::to_string(version.version) + " of the entry do not match its size and content id.");
}

Result<void> check_copied_thumbnail(const LibraryBody& from, const EntryRow& entry, std::span<const std::byte> picture) {
  if (picture.size() <= Library::max_thumbnail && is_picture(picture)) return {};
  return invalid(from, entry, "The thumbnail of the entry is neither PNG nor WebP, or is larger than 256 KB.");
}

}  // namespace ugoki::store
