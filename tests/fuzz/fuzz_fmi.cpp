#include <string>
#include <string_view>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/circuit/library.h"
#include "ugoki/fmi/archive.h"
#include "ugoki/fmi/declare.h"
#include "ugoki/fmi/load.h"
#include "ugoki/fmi/model_description.h"

namespace ugoki {
namespace {

void check_error(const Error& error) {
  UGOKI_CHECK(!error.problems.empty() && error.problems.size() <= 20);
  for (const Problem& p : error.problems) UGOKI_CHECK(!p.location.empty() && !p.message.empty());
}

/// Checks that a description which was read can become LSIs: a library accepts them after checking names and values.
void check_description(const fmi::ModelDescription& d) {
  UGOKI_CHECK(!d.identifier.empty() && d.identifier.find_first_of("./\\") == std::string::npos);
  circuit::Library library;
  for (const fmi::Declaration& declared : fmi::declare(d).classes) {
    circuit::LsiClass c = declared.lsi_class;
    c.advance = [](const circuit::Call*) { return std::int32_t{0}; };
    for (const fmi::PinBinding& b : declared.inputs) UGOKI_CHECK(b.pin < c.inputs.size() && b.count > 0);
    for (const fmi::PinBinding& b : declared.outputs) UGOKI_CHECK(b.pin < c.outputs.size() && b.count > 0);
    library.add(std::move(c));
  }
}

}  // namespace

void fuzz_fmu_description(const std::uint8_t* data, std::size_t size) {
  const auto d = fmi::read_model_description({reinterpret_cast<const char*>(data), size}, "fuzz.xml");
  if (!d) return check_error(d.error());
  check_description(*d);
}

void fuzz_fmu(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const auto archive = fmi::Archive::open(bytes, "fuzz.fmu");
  if (!archive) return check_error(archive.error());
  std::uint64_t unpacked = 0;
  for (const fmi::ArchiveEntry& e : archive->entries()) {
    UGOKI_CHECK(e.name.front() != '/' && ("/" + e.name).find("/../") == std::string::npos);
    if ((unpacked += e.bytes) > 1'000'000) break;
    const auto content = archive->read(e.name);
    if (content) UGOKI_CHECK(content->size() == e.bytes);
  }
  const auto info = fmi::read_fmu_info("fuzz.fmu", bytes);
  if (!info) return check_error(info.error());
  check_description(info->description);
}

}  // namespace ugoki
