#pragma once
// Good files that are databases, changed before a reader gets them. The input is a list of changes, one a line:
//   TABLE.COLUMN KEY VALUE   sets a column of the row with this number (of `property`: this name); checksums of data are put right
//   - TABLE KEY              removes a row
//   @ OFFSET BYTES           overwrites bytes of the file, after all other changes

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki {

[[nodiscard]] std::vector<std::byte> bytes_of(std::string_view text);

/// A folder of this process, in memory where the system has such a place.
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
/// Ends SQLite's write-ahead log, so that the file is all there is.
void into_one_file(const std::string& path);
/// The good file with all changes of the input, at `path`. False: they change nothing.
bool make_changed(const std::string& good, std::string_view input, const std::string& path);

}  // namespace ugoki
