#include "ugoki/circuit/activity.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace ugoki::circuit {
namespace {

/// Appends text to the caller's buffer and truncates the text at the end of the buffer.
class Text {
 public:
  explicit Text(std::span<char> buffer) : buffer_(buffer) {}
  Text& operator<<(std::string_view text) {
    for (const char c : text)
      if (size_ + 1 < buffer_.size()) buffer_[size_++] = c;
    return *this;
  }
  Text& operator<<(std::uint64_t n) {
    char digits[24];
    return *this << std::string_view(digits, std::to_chars(digits, digits + sizeof digits, n).ptr);
  }
  Text& operator<<(double x) {
    char digits[40];
    return *this << std::string_view(digits, std::to_chars(digits, digits + sizeof digits, x).ptr);
  }
  Text& seconds(double x) {
    char digits[48];
    const auto end = std::to_chars(digits, digits + sizeof digits, x, std::chars_format::fixed, 3);
    return *this << (end.ec == std::errc{} ? std::string_view(digits, end.ptr) : std::string_view("?"));
  }
  std::size_t finish() {
    if (!buffer_.empty()) buffer_[size_] = '\0';
    return size_;
  }

 private:
  std::span<char> buffer_;
  std::size_t size_ = 0;
};

}  // namespace

std::size_t describe_lsi(const RunningLsi& lsi, std::span<char> buffer) {
  Text text(buffer);
  text << "'" << lsi.id << "' (LSI '" << lsi.lsi_class->name << "'";
  if (!lsi.lsi_class->from.empty()) text << " of library '" << lsi.lsi_class->from << "'";
  text << ")";
  return text.finish();
}

std::size_t describe_time(const RunningLsi& lsi, std::span<char> buffer) {
  Text text(buffer);
  if (lsi.call && lsi.call->tick)
    (text << " at ").seconds(lsi.call->tick->time) << " s (tick " << std::uint64_t{lsi.call->tick->index} << ")";
  else
    text << " while the circuit was built";
  return text.finish();
}

std::size_t describe_inputs(const RunningLsi& lsi, std::span<char> buffer) {
  constexpr std::size_t max_pins = 6, max_numbers = 7;
  Text text(buffer);
  std::size_t printed = 0;
  for (std::size_t pin = 0; lsi.call && pin < lsi.lsi_class->inputs.size() && printed < max_pins; ++pin) {
    const InputPin& declared = lsi.lsi_class->inputs[pin];
    const PinType& type = pin_type(declared.type);
    const std::uint32_t wire = lsi.call->in_first[pin];
    if (declared.multiple || !type.numeric || !lsi.call->in[wire]) continue;
    const std::size_t numbers = payload_bytes(type, lsi.call->in_count[wire]) / sizeof(double);
    if (numbers == 0 || numbers > max_numbers) continue;
    text << (printed++ ? ", '" : " Its inputs were '") << declared.name << "' = ";
    const auto* x = static_cast<const double*>(lsi.call->in[wire]);
    for (std::size_t i = 0; i < numbers; ++i) text << (i ? ", " : numbers > 1 ? "[" : "") << x[i];
    if (numbers > 1) text << "]";
  }
  if (printed) text << ".";
  return text.finish();
}

}  // namespace ugoki::circuit
