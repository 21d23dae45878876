#pragma once
// Writes a binary FBX 7.4 file record by record. Internal to scene_formats.

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki::scene_formats {

/// For each record call begin(), one function for each property, begin() ... end() for each child record, and end(). take() returns the
/// finished file.
class FbxWriter {
 public:
  FbxWriter() {
    out_.append("Kaydara FBX Binary  \0\x1a\0", 23);
    put(std::uint32_t{7400});
  }
  void begin(std::string_view name) {
    if (!open_.empty()) close_properties();
    open_.push_back({out_.size()});
    put(std::uint32_t{0});
    put(std::uint32_t{0});
    put(std::uint32_t{0});
    out_ += static_cast<char>(name.size());
    out_ += name;
    open_.back().properties = out_.size();
  }
  void end() {
    Open& record = open_.back();
    if (record.closed)
      out_.append(13, '\0');  // an empty record marks the end of the child records
    else
      close_properties();
    patch(record.at, static_cast<std::uint32_t>(out_.size()));
    open_.pop_back();
  }
  /// Ends the properties of the open record, so that end() writes the end mark of child records even if there are none.
  void scope() {
    if (!open_.back().closed) close_properties();
  }
  void integer(std::int32_t x) { property('I', x); }
  void long_integer(std::int64_t x) { property('L', x); }
  void number(double x) { property('D', x); }
  void text(std::string_view x) {
    property('S', static_cast<std::uint32_t>(x.size()));
    out_ += x;
  }
  template <class T>
  void array(char type, const std::vector<T>& numbers) {
    property(type, static_cast<std::uint32_t>(numbers.size()));
    put(std::uint32_t{0});
    put(static_cast<std::uint32_t>(numbers.size() * sizeof(T)));
    out_.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
  }
  [[nodiscard]] std::string take() {
    out_.append(13, '\0');
    return std::move(out_);
  }

 private:
  /// A record that is not finished yet: offsets of its header and properties, number of properties, whether all its properties are written.
  struct Open {
    std::size_t at = 0, properties = 0;
    std::uint32_t count = 0;
    bool closed = false;
  };
  template <class T>
  void put(T x) {
    out_.append(reinterpret_cast<const char*>(&x), sizeof x);
  }
  template <class T>
  void property(char type, T x) {
    ++open_.back().count;
    out_ += type;
    put(x);
  }
  void patch(std::size_t at, std::uint32_t x) { std::memcpy(out_.data() + at, &x, sizeof x); }
  void close_properties() {
    Open& record = open_.back();
    if (record.closed) return;
    record.closed = true;
    patch(record.at + 4, record.count);
    patch(record.at + 8, static_cast<std::uint32_t>(out_.size() - record.properties));
  }

  std::string out_;
  std::vector<Open> open_;
};

}  // namespace ugoki::scene_formats
