#pragma once
// Videos that ffmpeg writes.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "child.h"
#include "export.h"
#include "ugoki/base/result.h"

namespace ugoki::cli {

/// The pictures of videos, which arrive as raw pixels.
struct VideoPictures {
  int width = 0, height = 0;  ///< px
  double rate = 0;            ///< pictures per second
  bool planar = false;  ///< true: YCbCr 4:2:0 (BT.709, limited range), rows from the top; false: RGBA, rows from the bottom as in WebGL
  bool transparent = false;  ///< keep the alpha of RGBA where the format has it
};

/// The videos of one export. Each is a temporary file until finish(); files that are not finished are removed.
class VideoFiles {
 public:
  /// @param ffmpeg path of the program  @param log file that receives its output
  VideoFiles(std::string ffmpeg, const VideoPictures& pictures, std::filesystem::path log);
  VideoFiles(const VideoFiles&) = delete;
  VideoFiles& operator=(const VideoFiles&) = delete;
  ~VideoFiles();

  /// Starts one ffmpeg for each video that is wanted.
  Result<void> start(const PictureOutputs& outputs);

  /// Adds a picture to all videos.
  Result<void> write(const std::string& picture);

  /// Completes the files. @return their names
  Result<std::vector<std::string>> finish();

 private:
  struct Video {
    std::string file, part;
    std::unique_ptr<Child> ffmpeg;
  };

  [[nodiscard]] std::vector<std::string> coder(std::initializer_list<const char*> words) const;
  Result<void> start(const std::string& file, const char* ending, const std::vector<std::string>& codec);

  std::string ffmpeg_;
  std::filesystem::path log_;
  bool planar_, alpha_;
  std::vector<std::string> input_;  // arguments that describe the pictures
  std::vector<Video> started_;
};

}  // namespace ugoki::cli
