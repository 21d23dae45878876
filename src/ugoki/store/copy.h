#pragma once
// Copies entries from one library to another: migration between SQLite and PostgreSQL, export and import of sets.

#include <functional>
#include <string>
#include <vector>

#include "ugoki/store/library.h"

namespace ugoki::store {

struct CopyOptions {
  std::vector<std::string> entries;  ///< ids of the entries to copy; empty: all entries, including the trash
  bool latest_only = false;          ///< true: copy only the newest version of each entry
  /// For an entry that was changed in both libraries. False: the target's entry is unchanged and listed in CopyReport::differing.
  /// True: the source's newest version is added to the target as its newest version.
  bool save_differing = false;
  std::function<void(double)> progress;  ///< called with the completed fraction, 0 ... 1; may be empty
  std::function<bool()> stop;            ///< returns true to stop after the current transaction; may be empty
};

struct CopyReport {
  std::size_t added = 0;                ///< number of entries that the target did not contain
  std::size_t continued = 0;            ///< number of entries to which newer versions were added
  std::size_t equal = 0;                ///< number of entries that the target already contained, with the same or newer versions
  std::size_t saved = 0;                ///< number of differing entries whose newest version was added to the target (save_differing)
  std::vector<std::string> differing;   ///< entries changed in both libraries and not copied: "n-... 'walk': ..."
  std::size_t versions = 0, blobs = 0;  ///< numbers of versions and blobs (data, thumbnails) written
};

/// Copies entries with their versions, tags, thumbnails and data. Each entry is copied completely or not at all. A repeated copy continues
/// where the previous one stopped, and changes nothing if nothing is new. Tags are added, never removed.
[[nodiscard]] Result<CopyReport> copy_entries(const Library& from, Library& to, const CopyOptions& options = {});

/// Writes entries into the file `path`, which becomes a library. An existing file is replaced atomically.
/// @param ids ids of the entries; the entries to which they refer are included (see with_references())
[[nodiscard]] Result<CopyReport> export_set(const Library& from, const std::vector<std::string>& ids, const std::string& path,
                                            const CopyOptions& options = {});

/// Ids of the entries and of all entries that they refer to, directly or indirectly, each once. An entry refers to the ids in its summary
/// (a motion to its mechanism); a set also refers to the ids in its list.
[[nodiscard]] Result<std::vector<std::string>> with_references(const Library& library, const std::vector<std::string>& ids);

}  // namespace ugoki::store
