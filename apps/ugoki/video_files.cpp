#include "video_files.h"

#include "output.h"
#include "ugoki/base/number.h"

namespace ugoki::cli {

namespace fs = std::filesystem;

VideoFiles::VideoFiles(std::string ffmpeg, const VideoPictures& pictures, fs::path log)
    : ffmpeg_(std::move(ffmpeg)), log_(std::move(log)), planar_(pictures.planar), alpha_(pictures.transparent) {
  input_ = {"-f",       "rawvideo",
            "-pix_fmt", planar_ ? "yuv420p" : "rgba",
            "-s",       std::to_string(pictures.width) + "x" + std::to_string(pictures.height),
            "-r",       to_text(pictures.rate),
            "-i",       "-",
            "-an"};
}

VideoFiles::~VideoFiles() {
  for (Video& v : started_) {
    v.ffmpeg.reset();
    std::error_code ignored;
    if (!v.part.empty()) fs::remove(v.part, ignored);
  }
}

Result<void> VideoFiles::start(const PictureOutputs& outputs) {
  // A constant quantiser instead of a constant quality (-crf) saves the analysis of each picture in advance, a third of the encoder's time.
  if (Result<void> done =
          start(outputs.mp4, ".mp4",
                coder({"-c:v", "libx264", "-preset", "ultrafast", "-qp", "17", "-pix_fmt", "yuv420p", "-movflags", "+faststart"}));
      !done)
    return done;
  if (Result<void> done = start(outputs.webm, ".webm",
                                coder({"-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1", "-deadline", "good", "-cpu-used",
                                       "5", "-pix_fmt", alpha_ ? "yuva420p" : "yuv420p"}));
      !done)
    return done;
  return start(outputs.gif, ".gif",
               {"-vf", "vflip,split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=4", "-loop", "0"});
}

Result<void> VideoFiles::write(const std::string& picture) {
  for (const Video& v : started_)
    if (!v.ffmpeg->write(picture))
      return fail(ErrorCode::io, v.file, "ffmpeg stopped." + tail_of(log_),
                  "Check the permissions of the folder and the free space on the disk.");
  return {};
}

Result<std::vector<std::string>> VideoFiles::finish() {
  std::vector<std::string> written;
  for (Video& v : started_) {
    if (!v.ffmpeg->wait())
      return fail(interrupted()
                      ? interrupted_error()
                      : Error(ErrorCode::io, v.file, "ffmpeg reported an error." + tail_of(log_), "Check that ffmpeg has the codec."));
    std::error_code ec;
    fs::rename(v.part, v.file, ec);
    if (ec) return fail(ErrorCode::io, v.file, "The video cannot be renamed: " + ec.message() + ".", "Check the folder's permissions.");
    v.part.clear();
    written.push_back(v.file);
  }
  return written;
}

// Videos have the colours of ITU-R BT.709, limited range. The file states this, because players assume BT.709 for large pictures only.
// The rows of RGBA pictures arrive from the bottom to the top, in the order of WebGL; vflip turns them.
std::vector<std::string> VideoFiles::coder(std::initializer_list<const char*> words) const {
  std::vector<std::string> out;
  if (!planar_) out = {"-vf", "vflip,scale=out_color_matrix=bt709:out_range=tv"};
  out.insert(out.end(), words.begin(), words.end());
  out.insert(out.end(), {"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"});
  return out;
}

/// Starts ffmpeg for one file; does nothing if `file` is empty.
Result<void> VideoFiles::start(const std::string& file, const char* ending, const std::vector<std::string>& codec) {
  if (file.empty()) return {};
  const fs::path target = file;
  std::error_code missing;
  if (fs::exists(target, missing) && !fs::is_regular_file(target, missing))
    return fail(ErrorCode::io, file, "Videos can be written only to files, not to folders, pipes and devices.", "Name another file.");
  const std::string part = (target.parent_path() / ("." + target.filename().string() + ".part" + ending)).string();
  std::vector<std::string> command = {ffmpeg_, "-hide_banner", "-loglevel", "error", "-y"};
  command.insert(command.end(), input_.begin(), input_.end());
  command.insert(command.end(), codec.begin(), codec.end());
  command.push_back(part);
  Result<std::unique_ptr<Child>> child = Child::start(command, true, log_.string());
  if (!child) return fail(std::move(child.error()));
  started_.push_back({file, part, std::move(*child)});
  return {};
}

}  // namespace ugoki::cli
