#include "ugoki/studio/export_service.h"

#include <algorithm>

#include "ugoki/circuit/circuit.h"
#include "ugoki/content/player.h"
#include "ugoki/json/json.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/carry.h"
#include "ugoki/publish/page.h"
#include "ugoki/publish/parts.h"
#include "ugoki/publish/payload.h"
#include "ugoki/publish/take.h"

namespace ugoki::studio {
namespace {

std::string text_of(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

Result<std::vector<plugin::CarriedFile>> used_libraries(std::string_view name, const std::vector<std::byte>& ugx) {
  const Result<content::Executable> content = content::read_executable(ugx, name);
  if (!content) return fail(content.error());
  const Result<circuit::Circuit> circuit = circuit::read_circuit(content->circuit);
  if (!circuit) return fail(circuit.error());
  return plugin::libraries_of(*circuit, lsi::standard_library(), plugin::read_shelf(plugin::default_shelf()));
}

Result<ApiReply> list_libraries(const std::vector<plugin::CarriedFile>& files) {
  json::Json list = json::Json::array();
  for (const plugin::CarriedFile& file : files)
    list.push_back({{"name", file.library}, {"sha256", file.hash}, {"bytes", file.bytes.size()}});
  return ApiReply{200, json::to_text({{"libraries", std::move(list)}}), "application/json"};
}

/// Returns a native program. @param files libraries that it carries
Result<ApiReply> native_program(std::string_view name, const std::vector<std::byte>& ugx, const std::vector<plugin::CarriedFile>& files) {
  Result<std::string> page = publish::read_player_part("player.html");
  if (!page) return fail(std::move(page.error()));
  page = publish::make_page(std::move(*page), name, ugx, publish::PageEngine::native);
  if (!page) return fail(std::move(page.error()));
  const Result<std::string> program = publish::read_player_part(files.empty() ? "ugoki_player" : "ugoki_lsi_player");
  if (!program) return fail(program.error());
  std::vector<publish::CarriedLibrary> libraries;
  for (const plugin::CarriedFile& file : files) libraries.push_back({file.name, std::as_bytes(std::span(file.bytes))});
  return ApiReply{200, text_of(publish::append_payload(std::as_bytes(std::span(*program)), *page, ugx, libraries)),
                  "application/octet-stream"};
}

}  // namespace

Result<ApiReply> export_content(std::string_view form, std::string_view name, const std::vector<std::byte>& ugx) {
  if (form == "ugx") return ApiReply{200, text_of(ugx), "application/octet-stream"};
  if (form == "libraries" || form == "native-lsis") {
    const Result<std::vector<plugin::CarriedFile>> files = used_libraries(name, ugx);
    if (!files) return fail(files.error());
    if (form == "libraries") return list_libraries(*files);
    if (!files->empty()) return native_program(name, ugx, *files);
  }
  // The content is opened with the standard LSIs only, because a page, and a program without libraries, have no others.
  Result<content::Player> player = content::Player::open(ugx, name);
  if (!player) return fail(std::move(player.error()));
  if (form == "native" || form == "native-lsis") return native_program(name, ugx, {});
  if (form == "html") {
    Result<std::string> page = publish::read_player_part("player.html");
    if (page) page = publish::make_page(std::move(*page), name, ugx);
    if (!page) return fail(std::move(page.error()));
    // Pages are sent as octet-stream too. A page that the studio's origin showed could run its scripts with the studio's rights.
    return ApiReply{200, std::move(*page), "application/octet-stream"};
  }
  const bool bvh = form == "bvh" || form.starts_with("bvh.");
  if (form != "glb" && form != "usda" && form != "csv" && !bvh)
    return fail(ErrorCode::unknown, "/api/export", "'" + std::string(form) + "' is not a form of export.",
                "Use html, native, native-lsis, libraries, ugx, glb, usda, csv, bvh, or bvh. and the id of a character.");
  const Result<publish::Take> take = publish::record_take(*player, player->content().duration, player->content().frame_rate);
  if (!take) return fail(take.error());
  if (bvh) {
    Result<std::string> text = publish::write_take_bvh(*take, form.substr(std::min(form.size(), std::string_view("bvh.").size())));
    if (!text) return fail(std::move(text.error()));
    return ApiReply{200, std::move(*text), "application/octet-stream"};
  }
  if (form == "glb") return ApiReply{200, text_of(publish::write_take_glb(*take)), "application/octet-stream"};
  return ApiReply{200, form == "usda" ? publish::write_take_usda(*take) : publish::write_take_csv(*take), "application/octet-stream"};
}

}  // namespace ugoki::studio
