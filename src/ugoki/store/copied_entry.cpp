#include "ugoki/store/copied_entry.h"

#include <algorithm>
#include <limits>

#include "ugoki/store/words.h"

namespace ugoki::store {
namespace {

std::unexpected<Error> unfit(const LibraryBody& from, const EntryRow& entry, std::string sentence) {
  return fail(ErrorCode::structure, from.place(clean_text(entry.id)), std::move(sentence),
              "Nothing of it was taken over. Run `ugoki db check` on the library that it comes from, or ask for the set again.");
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
  if (versions.empty()) return unfit(from, entry, "The entry has no version.");
  const Result<EntryKind> kind = entry_kind_named(entry.kind);
  if (!kind) return unfit(from, entry, "The entry is of a kind that this program does not know.");
  if (!is_id_of(entry.id, *kind)) return unfit(from, entry, "The id of the entry is none of a " + entry.kind + ".");
  if (!is_clean({entry.created, entry.changed, entry.removed, entry.removed_by}) || entry.created.empty() || entry.changed.empty())
    return unfit(from, entry, "The times of the entry cannot be read.");
  for (const std::string& tag : entry.tags)
    if (tag.empty() || !is_clean({tag})) return unfit(from, entry, "A tag of the entry is empty or no text.");
  std::int64_t before = 0;
  for (const VersionRow& v : versions) {
    if (v.version <= before || v.version >= std::numeric_limits<int>::max())
      return unfit(from, entry, "The versions of the entry are not numbered upwards from 1.");
    before = v.version;
    if (Result<void> good = check_item(from, entry.id, v.name, v.summary); !good) return good;
    if (!is_clean({v.name, v.summary, v.note, v.author, v.saved}))
      return unfit(from, entry, "Version " + std::to_string(v.version) + " of the entry holds what is no text.");
    if (!is_id_of(v.content, *kind))
      return unfit(from, entry, "Version " + std::to_string(v.version) + " of the entry has no id of its data.");
  }
  if (entry.newest != versions.back()) return unfit(from, entry, "The entry differs from its newest version.");
  return {};
}

Result<void> check_copied_data(const LibraryBody& from, const EntryRow& entry, const VersionRow& version, std::span<const std::byte> data) {
  const Result<EntryKind> kind = entry_kind_named(entry.kind);
  if (!kind) return fail(kind.error());
  if (version.size == static_cast<std::int64_t>(data.size()) && version.content == entry_id(*kind, data)) return {};
  return unfit(from, entry, "The data of version " + std::to_string(version.version) + " of the entry are not those that it names.");
}

Result<void> check_copied_thumbnail(const LibraryBody& from, const EntryRow& entry, std::span<const std::byte> picture) {
  if (picture.size() <= Library::most_thumbnail && is_picture(picture)) return {};
  return unfit(from, entry, "The thumbnail of the entry is neither PNG nor WebP, or too large.");
}

}  // namespace ugoki::store
