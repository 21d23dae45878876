#pragma once
// Fuzzing of database files: a valid file is changed before a reader opens it. The fuzz input is a list of changes, one per line:
//   TABLE.COLUMN KEY VALUE   sets a column of the row with rowid KEY (table `property`: with name KEY); checksums of data are corrected
//   - TABLE KEY              removes the row with this KEY
//   @ OFFSET BYTES           overwrites bytes of the file; applied after all other changes

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki {

[[nodiscard]] std::vector<std::byte> bytes_of(std::string_view text);

/// A temporary folder of this process, in memory if the system supports it.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return path_ + "/" + name; }
  void clear() const;

 private:
  std::string path_;
};

[[nodiscard]] std::string read_all(const std::string& path);
void write_all(const std::string& path, std::string_view bytes);
/// Merges SQLite's write-ahead log into the file, so that the file alone contains all data.
void into_one_file(const std::string& path);
/// Applies the changes listed in `input` to the bytes `good` of a valid file, and writes the changed file to `path`.
/// @return false if the input changes nothing
bool make_changed(const std::string& good, std::string_view input, const std::string& path);

}  // namespace ugoki
