#pragma once
// The records of an FBX file, binary or ASCII, as they stand: checked to lie within each other. Internal to scene_formats.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// A property of a record. Texts are views into the file.
struct FbxValue {
  enum class Kind : std::uint8_t { number, text, array };
  Kind kind = Kind::text;
  double number = 0;
  std::int64_t whole = 0;      ///< of a whole number, exactly
  std::string_view text = {};  ///< of an array: its bytes, or numbers with commas between
  char type = 0;               ///< of an array: 'd', 'f', 'l', 'i', 'b', or 'a' where it is written as text
  std::uint32_t count = 0;
  bool packed = false;  ///< by zlib
};

struct FbxRecord {
  std::string_view name;
  std::size_t at = 0;  ///< byte in the file
  std::vector<FbxValue> values;
  std::vector<FbxRecord> children;
  [[nodiscard]] const FbxRecord* child(std::string_view wanted) const;
  /// Text number `i`; empty: there is none.
  [[nodiscard]] std::string_view text(std::size_t i) const;
};

class FbxFile {
 public:
  explicit FbxFile(std::string_view place) : place_(place) {}
  /// Reads all records; refuses what is no FBX, cut off, nested too deeply, or longer than the file.
  [[nodiscard]] Result<void> load(std::string_view bytes);
  [[nodiscard]] const FbxRecord& root() const { return root_; }
  /// 7400; 0: the file does not tell.
  [[nodiscard]] std::int64_t version() const;
  /// A problem at this record.
  [[nodiscard]] std::unexpected<Error> refuse(const FbxRecord& record, ErrorCode code, std::string message) const;
  /// The numbers of a record that holds an array, each finite and at most `most`.
  [[nodiscard]] Result<std::vector<double>> numbers(const FbxRecord& record, double most) const;
  [[nodiscard]] Result<std::vector<std::int64_t>> integers(const FbxRecord& record) const;

 private:
  [[nodiscard]] Result<void> read_binary();
  [[nodiscard]] Result<void> read_text();
  /// The array's bytes as they are without zlib.
  [[nodiscard]] Result<std::string> unpacked(const FbxRecord& record, const FbxValue& array) const;
  template <class T>
  [[nodiscard]] Result<std::vector<T>> array(const FbxRecord& record) const;

  std::string place_;
  std::string_view bytes_;
  bool binary_ = false;
  std::uint32_t binary_version_ = 0;
  FbxRecord root_;
};

}  // namespace ugoki::scene_formats
