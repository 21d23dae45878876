#include "ugoki/formats/c3d_parameters.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

std::uint32_t byte_at(const std::byte* p, int i) { return std::to_integer<std::uint32_t>(p[i]); }
int signed_byte(std::byte b) { return static_cast<std::int8_t>(std::to_integer<std::uint8_t>(b)); }

/// Returns the bytes as text in capital letters, because the case of parameter names is ignored.
std::string name_at(std::span<const std::byte> bytes) {
  std::string name;
  for (const std::byte b : bytes) {
    const char c = static_cast<char>(b);
    name.push_back(c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c);
  }
  return name;
}

}  // namespace

std::uint16_t C3dNumbers::word(const std::byte* p) const {
  const bool big = processor == C3dProcessor::mips;
  return static_cast<std::uint16_t>(byte_at(p, big ? 0 : 1) << 8 | byte_at(p, big ? 1 : 0));
}

float C3dNumbers::real(const std::byte* p) const {
  switch (processor) {
    case C3dProcessor::intel: return std::bit_cast<float>(byte_at(p, 3) << 24 | byte_at(p, 2) << 16 | byte_at(p, 1) << 8 | byte_at(p, 0));
    case C3dProcessor::mips: return std::bit_cast<float>(byte_at(p, 0) << 24 | byte_at(p, 1) << 16 | byte_at(p, 2) << 8 | byte_at(p, 3));
    case C3dProcessor::dec: break;
  }
  // DEC F format: the two 16-bit words are swapped. With the exponent e and the binary mantissa m, the value is 0.1m * 2^(e - 128) = 1.m *
  // 2^(e - 129). The same bits read as an IEEE number give four times this value.
  const std::uint32_t bits = byte_at(p, 1) << 24 | byte_at(p, 0) << 16 | byte_at(p, 3) << 8 | byte_at(p, 2);
  const int exponent = static_cast<int>(bits >> 23 & 0xff);
  if (exponent == 0) return (bits & 0x7fffff) != 0 && bits >> 31 != 0 ? std::numeric_limits<float>::quiet_NaN() : 0.0f;
  const double mantissa = 1.0 + static_cast<double>(bits & 0x7fffff) / 8388608.0;
  const double value = std::ldexp(mantissa, exponent - 129);
  return static_cast<float>(bits >> 31 != 0 ? -value : value);
}

Result<C3dParameters> C3dParameters::read(std::span<const std::byte> file, std::size_t at, std::string_view file_name) {
  const std::string location = std::string(file_name) + ": parameters";
  constexpr const char* again = "Export or copy the file again.";
  if (at + 4 > file.size()) return fail(ErrorCode::truncated, location, "The file ends before its parameter section.", again);
  C3dParameters out;
  const int processor = static_cast<int>(byte_at(file.data() + at, 3));
  // Some programs write 0 instead of 84 for Intel.
  if (processor != 0 && (processor < 84 || processor > 86))
    return fail(ErrorCode::unsupported, location,
                "The processor type is " + std::to_string(processor) + "; it must be 84 (Intel), 85 (DEC) or 86 (SGI/MIPS).",
                "Check that the file is a C3D file, or export it again.");
  out.numbers_.processor = processor == 0 ? C3dProcessor::intel : static_cast<C3dProcessor>(processor);
  std::vector<std::pair<int, std::string>> groups;
  std::vector<int> group_of;
  std::string last = "the beginning of the section";  // name of the last parameter read, for messages
  const auto broken = [&](ErrorCode code, const std::string& fault) { return fail(code, location, fault + " after " + last + ".", again); };
  at += 4;
  while (true) {
    if (at + 2 > file.size()) break;  // a section that fills its last block has no end mark
    const std::size_t length = static_cast<std::size_t>(std::abs(signed_byte(file[at])));
    if (length == 0) break;
    const int id = signed_byte(file[at + 1]);
    if (at + 2 + length + 2 > file.size()) return broken(ErrorCode::truncated, "The file ends within the name of a parameter");
    const std::string name = name_at(file.subspan(at + 2, length));
    const std::size_t link = at + 2 + length;
    const std::size_t next = out.numbers_.word(file.data() + link);
    std::size_t p = link + 2;
    if (id == 0) return broken(ErrorCode::structure, "Parameter " + in_quotes(name) + " belongs to no group");
    if (id < 0) {
      groups.emplace_back(-id, name);
    } else {
      if (p + 2 > file.size()) return broken(ErrorCode::truncated, "The file ends within parameter " + in_quotes(name));
      C3dParameter parameter;
      parameter.name = name;
      parameter.type = signed_byte(file[p]);
      const std::size_t dimensions = byte_at(file.data() + p, 1);
      p += 2;
      const int type = parameter.type;
      if ((type != -1 && type != 1 && type != 2 && type != 4) || dimensions > 7)
        return broken(ErrorCode::structure, "Parameter " + in_quotes(name) + " has an unknown type or more than 7 dimensions");
      if (p + dimensions > file.size()) return broken(ErrorCode::truncated, "The file ends within parameter " + in_quotes(name));
      std::size_t size = static_cast<std::size_t>(std::abs(type));
      for (std::size_t k = 0; k < dimensions; ++k) {
        parameter.sizes.push_back(static_cast<int>(byte_at(file.data() + p + k, 0)));
        size *= static_cast<std::size_t>(parameter.sizes.back());
        if (size > file.size()) break;
      }
      p += dimensions;
      if (size > file.size() || p + size > file.size())
        return broken(ErrorCode::truncated, "The file ends within parameter " + in_quotes(name));
      parameter.bytes = file.subspan(p, size);
      out.parameters_.push_back(std::move(parameter));
      group_of.push_back(id);
    }
    last = in_quotes(name);
    if (next == 0) break;
    if (next < 2 || link + next <= at) return broken(ErrorCode::structure, "The offset to the next parameter is invalid");
    at = link + next;
    if (groups.size() + group_of.size() > 20'000) return broken(ErrorCode::structure, "There are more than 20000 parameters");
  }
  for (std::size_t i = 0; i < group_of.size(); ++i) {
    const auto it = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == group_of[i]; });
    if (it != groups.end()) out.parameters_[i].group = it->second;
  }
  return out;
}

const C3dParameter* C3dParameters::find(std::string_view group, std::string_view name) const {
  for (const C3dParameter& p : parameters_)
    if (p.group == group && p.name == name) return &p;
  return nullptr;
}

std::vector<double> C3dParameters::values(std::string_view group, std::string_view name) const {
  std::vector<double> out;
  const C3dParameter* p = find(group, name);
  if (p == nullptr || p->type == -1) return out;
  const std::size_t size = static_cast<std::size_t>(p->type);
  for (std::size_t i = 0; i + size <= p->bytes.size(); i += size) {
    const std::byte* at = p->bytes.data() + i;
    out.push_back(p->type == 1 ? std::to_integer<int>(*at) : p->type == 2 ? numbers_.integer(at) : static_cast<double>(numbers_.real(at)));
  }
  return out;
}

double C3dParameters::value(std::string_view group, std::string_view name, double otherwise) const {
  const std::vector<double> v = values(group, name);
  return v.empty() ? otherwise : v[0];
}

std::optional<double> C3dParameters::count(std::string_view group, std::string_view name) const {
  const C3dParameter* p = find(group, name);
  const std::vector<double> v = values(group, name);
  if (p == nullptr || v.empty() || !std::isfinite(v[0])) return std::nullopt;
  return p->type == 2 && v[0] < 0 ? v[0] + 65536 : v[0];
}

std::vector<std::string> C3dParameters::texts(std::string_view group, std::string_view name) const {
  std::vector<std::string> out;
  for (int part = 1; part <= 300; ++part) {
    const C3dParameter* p = find(group, part == 1 ? std::string(name) : std::string(name) + std::to_string(part));
    if (p == nullptr) {
      if (part == 1) continue;
      break;
    }
    if (p->type != -1 || p->bytes.empty()) continue;
    const std::size_t length = p->sizes.empty() ? 1 : static_cast<std::size_t>(p->sizes[0]);
    for (std::size_t at = 0; at + length <= p->bytes.size(); at += length) {
      std::string_view text(reinterpret_cast<const char*>(p->bytes.data()) + at, length);
      while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
      while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
      out.push_back(utf8(text));
    }
  }
  return out;
}

}  // namespace ugoki::formats
