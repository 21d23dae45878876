#include "ugoki/studio/static_files.h"

#include <fstream>
#include <iterator>
#include <system_error>

#include "ugoki/studio/security.h"

namespace ugoki::studio {
namespace {

namespace fs = std::filesystem;

std::unexpected<Error> not_found(std::string_view path) {
  return fail(ErrorCode::unknown, std::string(path), "The studio's page has no such file.",
              "Open the address that `ugoki studio` printed.");
}

/// True if `file` is inside the folder `root`; both must be canonical.
bool is_inside(const fs::path& file, const fs::path& root) {
  auto f = file.begin();
  for (auto r = root.begin(); r != root.end(); ++r, ++f) {
    if (f == file.end() || *f != *r) return false;
  }
  return f != file.end();
}

}  // namespace

std::string_view content_type_of(std::string_view path) {
  struct Ending {
    std::string_view ending, type;
  };
  constexpr Ending endings[] = {
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".mjs", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".map", "application/json"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".jpg", "image/jpeg"},
      {".webp", "image/webp"},
      {".ico", "image/x-icon"},
      {".woff2", "font/woff2"},
      {".wasm", "application/wasm"},
      {".txt", "text/plain; charset=utf-8"},
      {".webmanifest", "application/manifest+json"},
      {".glb", "model/gltf-binary"},
  };
  for (const Ending& e : endings) {
    if (path.ends_with(e.ending)) return e.type;
  }
  return "application/octet-stream";
}

Result<StaticFile> read_static_file(const fs::path& root, std::string_view path) {
  if (!is_plain_path(path)) {
    return fail(ErrorCode::unknown, std::string(path), "The path leads outside of the studio's page.",
                "Open the address that `ugoki studio` printed.");
  }
  std::error_code ec;
  const fs::path folder = fs::canonical(root, ec);
  if (ec) {
    return fail(ErrorCode::io, root.string(), "The folder of the studio's page cannot be read: " + ec.message() + ".",
                "Build it with `npm ci && npm run build` in web/, or name its folder with --web.");
  }
  const std::string relative = path == "/" ? "index.html" : std::string(path.substr(1));
  const fs::path file = fs::canonical(folder / relative, ec);
  if (ec || !is_inside(file, folder) || !fs::is_regular_file(file, ec)) return not_found(path);
  std::ifstream in(file, std::ios::binary);
  StaticFile out;
  out.bytes.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  if (!in.good() && !in.eof()) return fail(ErrorCode::io, file.string(), "The file cannot be read.", "Check the file's permissions.");
  out.content_type = content_type_of(relative);
  out.immutable = path.starts_with("/assets/");
  return out;
}

std::optional<fs::path> find_web_folder(const fs::path& executable) {
  std::error_code ec;
  fs::path folder = fs::weakly_canonical(executable, ec).parent_path();
  if (ec) return std::nullopt;
  const fs::path installed = folder.parent_path() / "share" / "ugoki" / "web";
  if (fs::is_regular_file(installed / "index.html", ec)) return installed;
  for (int up = 0; up < 4; ++up) {
    folder = folder.parent_path();
    const fs::path built = folder / "web" / "dist";
    if (fs::is_regular_file(built / "index.html", ec)) return built;
    if (folder == folder.root_path()) break;
  }
  return std::nullopt;
}

}  // namespace ugoki::studio
