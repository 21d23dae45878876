// `ugoki export`: writes finished content as a program, a page, pictures, or a file for other tools.

#include "export.h"

#include <sys/stat.h>

#include <algorithm>
#include <memory>

#include "output.h"
#include "output_files.h"
#include "simulate.h"
#include "sources.h"
#include "ugoki/content/inputs.h"
#include "ugoki/files/files.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/carry.h"
#include "ugoki/publish/page.h"
#include "ugoki/publish/parts.h"
#include "ugoki/publish/payload.h"
#include "ugoki/publish/take.h"
#include "ugoki/robot_formats/robot_writer.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string target, html, native, embed, ugx, glb, usda, csv, bvh, fmu, mjcf, urdf, fbx, abc, blender, character, inputs, player, title;
  SourceOptions source;
  PictureOutputs pictures;
  PictureOptions picture;
  std::vector<int> size = {1920, 1080};
  double take_rate = 0, duration = 0;
  int fmi_version = 3;
  bool carry_lsis = false, json = false;

  [[nodiscard]] std::vector<NamedFile> outputs() const {
    return {{"--html", html},        {"--native", native},
            {"--embed", embed},      {"--ugx", ugx},
            {"--glb", glb},          {"--usda", usda},
            {"--csv", csv},          {"--mjcf", mjcf},
            {"--urdf", urdf},        {"--fbx", fbx},
            {"--abc", abc},          {"--png", pictures.png},
            {"--mp4", pictures.mp4}, {"--webm", pictures.webm},
            {"--gif", pictures.gif}, {"--fmu", fmu},
            {"--bvh", bvh}};
  }
  /// The files that this verb reads.
  [[nodiscard]] std::vector<NamedFile> inputs_read() const {
    std::vector<NamedFile> out = input_files(target, source);
    out.push_back({"--inputs", inputs});
    return out;
  }
  [[nodiscard]] bool wants_take() const {
    return !glb.empty() || !usda.empty() || !csv.empty() || !bvh.empty() || !mjcf.empty() || !urdf.empty() || !fbx.empty() || !abc.empty();
  }
  [[nodiscard]] bool wants_page() const { return !html.empty() || !native.empty() || !embed.empty() || pictures.any(); }
};

/// One written file, for the report.
struct Written {
  std::string kind, file;
  std::uintmax_t bytes = 0;
};

/// Returns the installed libraries whose LSIs the content uses; empty: the content runs with the standard LSIs alone.
/// Error: the content is faulty.
Result<std::vector<plugin::CarriedFile>> used_libraries(std::span<const std::byte> ugx, const std::string& name) {
  const Result<content::Player> plain = content::Player::open(ugx, name);
  if (plain) return {};
  const Result<HostedPlayer> hosted = open_hosted(ugx, name);
  if (!hosted) return fail(plain.error());  // the content is faulty whatever the LSIs
  const Result<circuit::Circuit> circuit = circuit::read_circuit(hosted->player.content().circuit);
  if (!circuit) return fail(circuit.error());
  return plugin::libraries_of(*circuit, lsi::standard_library(), plugin::read_shelf(plugin::default_shelf()));
}

/// Checks that the content runs with the standard LSIs alone, because pages have no other LSIs.
Result<void> check_portable(std::span<const std::byte> ugx, const std::string& name, bool native) {
  const Result<content::Player> plain = content::Player::open(ugx, name);
  if (plain) return {};
  if (!open_hosted(ugx, name)) return fail(plain.error());  // the content is faulty whatever the LSIs
  Error error = plain.error();
  for (Problem& p : error.problems) {
    p.message += native ? " It comes from an installed library, which is native code. A program carries it only with your consent."
                        : " It comes from an installed library. Pages can use only the standard LSIs.";
    p.remedy = native ? "Add --carry-lsis if you may pass the library on, or replace this LSI by standard ones."
                      : "Replace this LSI by standard ones, or write --native with --carry-lsis, or pictures, videos, --glb, --usda or "
                        "--csv, which also simulate LSIs of installed libraries.";
  }
  return fail(std::move(error));
}

Result<void> write(std::vector<Written>& report, const char* kind, const std::string& file, std::span<const std::byte> bytes) {
  if (Result<void> done = files::write_file(file, bytes); !done) return done;
  report.push_back({kind, file, bytes.size()});
  return {};
}
Result<void> write(std::vector<Written>& report, const char* kind, const std::string& file, std::string_view text) {
  return write(report, kind, file, std::as_bytes(std::span(text)));
}

Result<void> write_native(const Options& o, const std::string& page, std::span<const std::byte> ugx, std::vector<Written>& report,
                          const std::string& title) {
  std::vector<plugin::CarriedFile> files;
  if (o.carry_lsis) {
    Result<std::vector<plugin::CarriedFile>> used = used_libraries(ugx, title);
    if (!used) return fail(std::move(used.error()));
    files = std::move(*used);
  }
  std::vector<publish::CarriedLibrary> libraries;
  for (const plugin::CarriedFile& file : files) libraries.push_back({file.name, std::as_bytes(std::span(file.bytes))});
  const Result<std::string> program = publish::read_player_part(libraries.empty() ? "ugoki_player" : "ugoki_lsi_player", o.player);
  if (!program) return fail(program.error());
  const Result<std::string> filled = publish::make_page(page, title, ugx, publish::PageEngine::native);
  if (!filled) return fail(filled.error());
  if (Result<void> done =
          write(report, "native", o.native, publish::append_payload(std::as_bytes(std::span(*program)), *filled, ugx, libraries));
      !done)
    return done;
  for (const plugin::CarriedFile& file : files) report.push_back({"library " + file.library, o.native, file.bytes.size()});
  if (!o.json)
    for (const plugin::CarriedFile& file : files)
      print_line("Carries the library '" + file.library + "' (SHA-256 " + file.hash +
                 "): its code runs with the rights of whoever starts the program.");
  struct stat facts{};
  if (::stat(o.native.c_str(), &facts) != 0 || ::chmod(o.native.c_str(), (facts.st_mode & 0777) | ((facts.st_mode & 0444) >> 2)) != 0)
    return fail(ErrorCode::io, o.native, "The file cannot be made executable.", "Make it executable with `chmod +x`.");
  return {};
}

/// Writes the folder of --embed: the element's script, the content, and an example page that uses both.
Result<void> write_embed(const Options& o, const std::string& name, std::span<const std::byte> ugx, std::vector<Written>& report,
                         const std::string& title) {
  const Result<std::string> script = publish::read_player_part("ugoki-player.js", o.player);
  if (!script) return fail(script.error());
  std::error_code ec;
  fs::create_directories(o.embed, ec);
  if (ec) return fail(ErrorCode::io, o.embed, "The folder cannot be created: " + ec.message() + ".", "Name another folder.");
  std::string file = name;
  std::ranges::replace_if(
      file,
      [](char c) {
        return c == '/' || static_cast<unsigned char>(c) < 0x20 || std::string_view("\\:*?\"<>|#%").find(c) != std::string_view::npos;
      },
      '-');
  file += ".ugx";
  const fs::path folder = o.embed;
  std::vector<NamedFile> outputs;
  for (const std::string& each : {std::string("ugoki-player.js"), file, std::string("index.html")})
    outputs.push_back({"a file in --embed", (folder / each).string()});
  if (Result<void> may = check_outputs(o.inputs_read(), outputs); !may) return may;
  if (Result<void> may = check_derived((folder / "index.html").string(), "<ugoki-player"); !may) return may;
  if (Result<void> done = write(report, "script", (folder / "ugoki-player.js").string(), *script); !done) return done;
  if (Result<void> done = write(report, "ugx", (folder / file).string(), ugx); !done) return done;
  const std::string page =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n<title>" +
      publish::escape_html(title) +
      "</title>\n<script src=\"ugoki-player.js\" defer></script>\n</head>\n<body>\n<!-- The files must be served over HTTP: a browser does "
      "not let "
      "a page from a disk read other files. -->\n<ugoki-player src=\"" +
      publish::escape_html(file) + "\" style=\"width: 100%; aspect-ratio: 16 / 9\"></ugoki-player>\n</body>\n</html>\n";
  return write(report, "page", (folder / "index.html").string(), page);
}

Result<publish::Take> run_take(const Options& o, std::span<const std::byte> ugx, const std::string& name, const std::string& inputs) {
  Result<HostedPlayer> hosted = open_hosted(ugx, name);
  if (!hosted) return fail(std::move(hosted.error()));
  const content::Executable& content = hosted->player.content();
  if (!inputs.empty()) {
    auto read = content::read_inputs(inputs, content, o.inputs);
    if (!read) return fail(std::move(read.error()));
    hosted->player.schedule(std::move(*read));
  }
  catch_interrupt();
  Progress progress("simulate " + name);
  return publish::record_take(hosted->player, o.duration > 0 ? o.duration : content.duration,
                              o.take_rate > 0 ? o.take_rate : content.frame_rate, [&](double done) {
                                progress.show(done);
                                return !interrupted();
                              });
}

/// Writes the simulated motion of one character as BVH.
Result<void> write_bvh(const publish::Take& take, const Options& o, std::vector<Written>& report) {
  const Result<std::string> text = publish::write_take_bvh(take, o.character);
  if (!text) return fail(text.error());
  return write(report, "bvh", o.bvh, *text);
}

/// Writes the mechanism of one character, with its motion, as MJCF or URDF. @param kind "mjcf" or "urdf"
Result<void> write_robot(const publish::Take& take, const Options& o, const char* kind, const std::string& path,
                         std::vector<Written>& report) {
  const Result<const publish::TakeCharacter*> character = publish::find_character(take, o.character);
  if (!character) return fail(character.error());
  const publish::TakeCharacter* chosen = *character;
  const fs::path file = path;
  const robot_formats::RobotMotion motion{take.rate, chosen->q};
  const robot_formats::RobotText text = std::string_view(kind) == "mjcf"
                                            ? robot_formats::write_mjcf(*chosen->mechanism, motion)
                                            : robot_formats::write_urdf(*chosen->mechanism, file.stem().string(), motion);
  for (const robot_formats::SideFile& extra : text.files) {
    const std::string beside = (file.parent_path() / extra.name).string();
    std::vector<NamedFile> outputs = o.outputs();
    outputs.push_back({"a file beside --" + std::string(kind), beside});
    if (Result<void> may = check_outputs(o.inputs_read(), outputs); !may) return may;
    if (Result<void> done = write(report, kind, beside, extra.text); !done) return done;
  }
  if (!o.json)
    for (const std::string& note : text.notes) print_line("Note: " + note);
  return write(report, kind, path, text.text);
}

int run_export(Options o) {
  if (Result<void> may = check_outputs(o.inputs_read(), o.outputs()); !may) return print_error(may.error(), o.json);
  Result<ExecutableSource> source = load_executable(o.target, o.source);
  if (!source) return print_error(source.error(), o.json);
  // Again, because only now the files are known to which the input refers.
  if (Result<void> may = check_outputs(o.inputs_read(), o.outputs()); !may) return print_error(may.error(), o.json);
  const std::span<const std::byte> ugx = source->ugx;
  const std::string title = o.title.empty() ? source->name : o.title;
  std::vector<Written> report;
  std::string inputs;
  if (!o.inputs.empty()) {
    Result<std::string> text = files::read_file(o.inputs);
    if (!text) return print_error(text.error(), o.json);
    inputs = std::move(*text);
  }
  const auto run = [&]() -> Result<void> {
    if (!o.ugx.empty())
      if (Result<void> done = write(report, "ugx", o.ugx, ugx); !done) return done;
    if (o.wants_page()) {
      const bool pages = !o.html.empty() || !o.embed.empty(), only_native = !o.native.empty() && !pages;
      if (pages || (only_native && !o.carry_lsis))
        if (Result<void> good = check_portable(ugx, source->name, only_native); !good) return good;
      Result<std::string> page = publish::read_player_part("player.html", o.player);
      if (!page) return fail(std::move(page.error()));
      if (!o.html.empty()) {
        const Result<std::string> filled = publish::make_page(*page, title, ugx);
        if (!filled) return fail(filled.error());
        if (Result<void> done = write(report, "html", o.html, *filled); !done) return done;
      }
      if (!o.native.empty())
        if (Result<void> done = write_native(o, *page, ugx, report, title); !done) return done;
      if (!o.embed.empty())
        if (Result<void> done = write_embed(o, source->name, ugx, report, title); !done) return done;
      if (o.pictures.any()) {
        o.picture.width = o.size[0];
        o.picture.height = o.size[1];
        o.picture.rate = o.take_rate;
        o.picture.duration = o.duration;
        o.picture.inputs = inputs;
        o.picture.player = o.player;
        const auto check = [&](const std::vector<std::string>& pictures) {
          std::vector<NamedFile> others = o.outputs();
          std::erase_if(others, [](const NamedFile& f) { return f.option == "--png"; });
          return check_pictures(o.inputs_read(), others, pictures);
        };
        const Result<std::vector<std::string>> drawn = export_pictures(*page, source->name, ugx, o.picture, o.pictures, check);
        if (!drawn) return fail(drawn.error());
        std::error_code ec;
        for (const std::string& file : *drawn) report.push_back({"picture", file, fs::file_size(file, ec)});
      }
    }
    if (!o.fmu.empty()) {
      std::vector<std::string> notes;
      const Result<std::string> fmu = make_content_fmu(ugx, source->name, o.fmi_version, notes);
      if (!fmu) return fail(fmu.error());
      if (!o.json)
        for (const std::string& note : notes) print_line("Note: " + note);
      if (Result<void> done = write(report, "fmu", o.fmu, *fmu); !done) return done;
    }
    if (o.wants_take()) {
      const Result<publish::Take> take = run_take(o, ugx, source->name, inputs);
      if (!take) return fail(take.error());
      if (!o.glb.empty())
        if (Result<void> done = write(report, "glb", o.glb, publish::write_take_glb(*take)); !done) return done;
      if (!o.usda.empty())
        if (Result<void> done = write(report, "usda", o.usda, publish::write_take_usda(*take)); !done) return done;
      if (!o.csv.empty())
        if (Result<void> done = write(report, "csv", o.csv, publish::write_take_csv(*take)); !done) return done;
      if (!o.bvh.empty())
        if (Result<void> done = write_bvh(*take, o, report); !done) return done;
      for (const auto& [kind, path] : {std::pair{"fbx", o.fbx}, {"abc", o.abc}}) {
        if (path.empty()) continue;
        if (Result<void> done = export_with_blender(publish::write_take_glb(*take), take->rate, path, o.blender); !done) return done;
        std::error_code ec;
        report.push_back({kind, path, fs::file_size(path, ec)});
      }
      if (!o.mjcf.empty())
        if (Result<void> done = write_robot(*take, o, "mjcf", o.mjcf, report); !done) return done;
      if (!o.urdf.empty())
        if (Result<void> done = write_robot(*take, o, "urdf", o.urdf, report); !done) return done;
    }
    return {};
  };
  if (const Result<void> done = run(); !done) return print_error(done.error(), o.json);
  if (o.json) {
    Json list = Json::array();
    for (const Written& w : report) list.push_back({{"kind", w.kind}, {"file", w.file}, {"bytes", w.bytes}});
    print_json({{"name", source->name}, {"files", std::move(list)}});
    return 0;
  }
  for (const Written& w : report) print_line("Wrote " + w.file + " (" + std::to_string((w.bytes + 999) / 1000) + " kB)");
  return 0;
}

}  // namespace

/// Returns a check: the name of the file must end with `ending`.
static std::function<std::string(const std::string&)> has_ending(std::string ending) {
  return [ending = std::move(ending)](const std::string& path) {
    return path.ends_with(ending) ? std::string() : "The name must end with " + ending + ".";
  };
}

void add_export_verb(Verb app, Action& action) {
  auto o = std::make_shared<Options>();
  Verb verb = app.add_subcommand("export", "Write content as a program, a page, pictures or a file for other tools.");
  verb.add_option("target", o->target, "Project (*.ugoki), executable data (*.ugx), motion file or motion of the library").required();
  const auto file = [&](const char* name, std::string& value, const char* help) {
    return verb.add_option(name, value, help).type_name("FILE");
  };
  file("--html", o->html, "One HTML file: plays live in any browser, from a disk, without a network").group("Programs");
  file("--native", o->native, "One executable file for Linux: opens its page, or runs with --headless").group("Programs");
  verb.add_flag("--carry-lsis", o->carry_lsis,
                "--native: the program carries the code of the installed libraries of LSIs that the content uses")
      .group("Programs");
  verb.add_option("--embed", o->embed, "Folder with the element <ugoki-player> for your own pages").type_name("FOLDER").group("Programs");
  file("--ugx", o->ugx, "Executable data, the input of every player").group("Programs");
  file("--png", o->pictures.png, "Pictures: a name with %d or %04d, or one picture at --from").group("Pictures");
  file("--mp4", o->pictures.mp4, "Video, H.264 (needs ffmpeg)").group("Pictures");
  file("--webm", o->pictures.webm, "Video, VP9 (needs ffmpeg)").group("Pictures");
  file("--gif", o->pictures.gif, "Animated GIF (needs ffmpeg)").group("Pictures");
  verb.add_option("--size", o->size, "Width and height of pictures, px")
      .delimiter('x')
      .expected(2)
      .check(range(16, 8192))
      .capture_default_str()
      .group("Pictures");
  verb.add_option("--from", o->picture.from, "Time of the first picture, s").check(range(0.0, 86400.0)).group("Pictures");
  verb.add_option("--blur", o->picture.blur, "Motion blur: sub-frames for each picture")
      .check(range(1, 64))
      .capture_default_str()
      .group("Pictures");
  verb.add_option("--shutter", o->picture.shutter, "Open fraction of the shutter, with --blur")
      .check(range(0.01, 1.0))
      .capture_default_str()
      .group("Pictures");
  verb.add_flag("--transparent", o->picture.transparent, "No floor and a transparent background (--png, --webm)").group("Pictures");
  verb.add_flag("--light", o->picture.light, "Light background").group("Pictures");
  verb.add_flag("--assist", o->picture.overlays, "Draw the root assist").group("Pictures");
  verb.add_option("--browser", o->picture.browser, "Chromium or Chrome (default: found on the path)").group("Pictures");
  verb.add_option("--ffmpeg", o->picture.ffmpeg, "ffmpeg (default: found on the path)").group("Pictures");
  file("--glb", o->glb, "glTF 2.0: skins, animation, camera, materials").group("Other tools");
  file("--usda", o->usda, "USD as text: UsdSkel, materials, camera").group("Other tools");
  file("--csv", o->csv, "Table of all link poses").group("Other tools");
  file("--bvh", o->bvh, "BVH: motion of one character").group("Other tools");
  file("--fmu", o->fmu, "FMU for co-simulation: Simulink, Modelica tools, FMPy").group("Other tools");
  verb.add_option("--fmi", o->fmi_version, "Version of FMI for --fmu").check(one_of({2, 3})).capture_default_str().group("Other tools");
  file("--fbx", o->fbx, "FBX, *.fbx, written by Blender").group("Other tools").check(Check(has_ending(".fbx"), "*.fbx"));
  file("--abc", o->abc, "Alembic, *.abc, written by a Blender with support for Alembic")
      .group("Other tools")
      .check(Check(has_ending(".abc"), "*.abc"));
  verb.add_option("--blender", o->blender, "Blender (default: found on the path)").group("Other tools");
  file("--mjcf", o->mjcf, "MuJoCo: mechanism of one character, its motion as keyframes").group("Other tools");
  file("--urdf", o->urdf, "URDF: mechanism of one character, its motion as a table beside it").group("Other tools");
  verb.add_option("--character", o->character, "Character for --bvh, --mjcf and --urdf: id or name (default: the first one)")
      .group("Other tools");
  verb.add_option("--rate", o->take_rate, "Frames per second of pictures and animations (default: that of the content)")
      .check(range(1.0, 1000.0));
  verb.add_option("--duration", o->duration, "Time at which pictures and animations end, s (default: the end)")
      .check(range(0.001, 86400.0));
  verb.add_option("--inputs", o->inputs, "Recorded inputs, JSON, for pictures and animations (docs/export.md)");
  verb.add_option("--title", o->title, "Title of the page (default: the name of the content)");
  verb.add_option("--player", o->player, "Folder with the parts of the player");
  add_skeleton_option(verb, o->source);
  add_library_option(verb, o->source.library);
  verb.add_flag("--json", o->json, "Print one JSON object");
  verb.footer(
      "Examples:\n  ugoki export park.ugoki --html park.html\n  ugoki export park.ugoki --native park --mp4 park.mp4 --size 1280x720\n"
      "  ugoki export walk.bvh --glb walk.glb");
  verb.callback([o, &action] {
    if (!o->wants_page() && !o->wants_take() && o->ugx.empty() && o->fmu.empty())
      refuse("export", "Name at least one file to write, for example --html park.html.");
    action = [o] { return with_libraries(o->json, [&] { return run_export(*o); }); };
  });
}

}  // namespace ugoki::cli
