#include "ugoki/circuit/input_record.h"

#include <bit>
#include <cmath>
#include <cstring>

#include "ugoki/base/number.h"
#include "ugoki/json/fields.h"
#include "ugoki/json/json.h"

namespace ugoki::circuit {
namespace {

using json::Json;

constexpr std::size_t max_readable = 7;  // numbers (a pose has 7); longer payloads are written as hexadecimal bytes

std::string hex(std::uint64_t word) {
  std::string out(16, '0');
  for (std::size_t i = 0; i < 16; ++i) out[i] = "0123456789abcdef"[(word >> (60 - 4 * i)) & 15];
  return out;
}

std::string hex(const std::vector<std::byte>& bytes) {
  std::string out;
  for (const std::byte b : bytes) {
    out += "0123456789abcdef"[static_cast<unsigned>(b) >> 4];
    out += "0123456789abcdef"[static_cast<unsigned>(b) & 15];
  }
  return out;
}

int digit(char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1; }

bool read_hex(const std::string& text, std::vector<std::byte>& bytes) {
  if (text.size() % 2 != 0) return false;
  bytes.clear();
  for (std::size_t i = 0; i < text.size(); i += 2) {
    const int high = digit(text[i]), low = digit(text[i + 1]);
    if (high < 0 || low < 0) return false;
    bytes.push_back(static_cast<std::byte>(high * 16 + low));
  }
  return true;
}

/// Writes the bytes as numbers: "[1, 2.5]".
/// Returns an empty text if the bytes are not 1 to max_readable finite doubles that decimal text keeps exactly (subnormals excluded).
std::string numbers_text(const std::vector<std::byte>& bytes) {
  const std::size_t n = bytes.size() / sizeof(double);
  if (n == 0 || n > max_readable || bytes.size() % sizeof(double) != 0) return {};
  std::string out = "[";
  for (std::size_t i = 0; i < n; ++i) {
    double x;
    std::memcpy(&x, bytes.data() + i * sizeof x, sizeof x);
    if (!std::isfinite(x) || (x != 0 && std::abs(x) < 1e-300)) return {};
    out += (i ? ", " : "") + to_text(x);
  }
  return out + "]";
}

void read_change(const Json& json, const std::string& path, Error& problems, InputChange& change) {
  json::Fields f(json, path, problems);
  double tick = 0;
  f.require("tick", "the tick before which the value was set");
  f.number("tick", tick);
  if (!(tick >= 0 && tick < 9e15 && std::floor(tick) == tick))
    f.report(ErrorCode::range, f.path("tick"), "A tick is an integer from 0.", "Use the record file unchanged.");
  else
    change.tick = static_cast<std::uint64_t>(tick);
  const char* name = f.has("parameter") ? "parameter" : "input";
  f.require(name, "the name of the input or parameter");
  f.text(name, change.name);
  if (f.has("parameter")) {
    change.component = 0;
    f.integer("component", change.component);
  }
  std::string bytes;
  if (f.has("bytes")) {
    f.text("bytes", bytes);
    if (!read_hex(bytes, change.bytes))
      f.report(ErrorCode::syntax, f.path("bytes"), "The bytes are not pairs of hexadecimal digits.", "Use the record file unchanged.");
  } else if (const Json* list = f.list("numbers", max_readable, "numbers")) {
    std::vector<double> numbers(list->size());
    if (f.numbers("numbers", numbers)) {
      change.bytes.resize(numbers.size() * sizeof(double));
      if (!numbers.empty()) std::memcpy(change.bytes.data(), numbers.data(), change.bytes.size());
    }
  }
  f.refuse_others();
}

}  // namespace

std::string write_input_record(const InputRecord& record) {
  std::string out = "{\n  \"version\": 1,\n  \"circuit\": \"" + hex(record.layout) + "\",\n  \"dt\": " + to_text(record.dt) +
                    ",\n  \"ticks\": " + std::to_string(record.ticks) + ",\n  \"changes\": [";
  for (std::size_t i = 0; i < record.changes.size(); ++i) {
    const InputChange& c = record.changes[i];
    out += (i ? ",\n    " : "\n    ") + std::string("{\"tick\": ") + std::to_string(c.tick) + ", \"" +
           (c.component < 0 ? "input" : "parameter") + "\": " + json::to_text(Json(c.name));
    if (c.component > 0) out += ", \"component\": " + std::to_string(c.component);
    const std::string numbers = numbers_text(c.bytes);
    out += numbers.empty() ? ", \"bytes\": \"" + hex(c.bytes) + "\"}" : ", \"numbers\": " + numbers + "}";
  }
  return out + (record.changes.empty() ? "]\n}\n" : "\n  ]\n}\n");
}

Result<InputRecord> read_input_record(std::string_view text, std::string_view location) {
  const Result<Json> json = json::parse_json(text, location);
  if (!json) return fail(json.error());
  Error problems;
  InputRecord record;
  json::Fields f(*json, std::string(location), problems);
  int version = 0;
  double ticks = 0;
  std::string circuit;
  f.require("version", "1");
  f.integer("version", version);
  if (problems.empty() && version != 1)
    f.report(ErrorCode::unsupported, f.path("version"), "This program reads records of version 1.", "Use the program that wrote it.");
  f.text("circuit", circuit);
  std::vector<std::byte> layout;
  if (circuit.size() != 16 || !read_hex(circuit, layout))
    f.report(ErrorCode::syntax, f.path("circuit"), "The hash of the circuit does not have 16 hexadecimal digits.",
             "Use the record file unchanged.");
  for (const std::byte b : layout) record.layout = record.layout << 8 | static_cast<std::uint64_t>(b);
  f.number("dt", record.dt);
  f.number("ticks", ticks);
  if (ticks >= 0 && ticks < 9e15) record.ticks = static_cast<std::uint64_t>(ticks);
  if (const Json* changes = f.list("changes", 10'000'000, "changes")) {
    record.changes.resize(changes->size());
    for (std::size_t i = 0; i < changes->size() && problems.problems.size() < json::max_problems; ++i)
      read_change((*changes)[i], f.path("changes") + "/" + std::to_string(i), problems, record.changes[i]);
  }
  f.refuse_others();
  if (!problems.empty()) return fail(std::move(problems));
  return record;
}

}  // namespace ugoki::circuit
