#pragma once
// Options and parts of `ugoki export`.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// How pictures are drawn and written.
struct PictureOptions {
  int width = 1920, height = 1080;  ///< px
  double rate = 0;                  ///< pictures per second; 0: the frame rate of the content
  double from = 0, duration = 0;    ///< s of the content; duration 0: to the end
  int blur = 1;                     ///< sub-frames that are averaged into one picture; 1: no motion blur
  double shutter = 0.5;             ///< fraction of the time between two pictures in which the sub-frames are
  bool transparent = false;         ///< PNG only
  bool overlays = false;            ///< draw the root assist
  bool light = false;               ///< light background instead of the dark one
  std::string browser, ffmpeg;      ///< programs; empty: found on the path
  std::string inputs;               ///< text of recorded inputs, JSON; empty: none
};

/// Files for which pictures are drawn; empty: not wanted.
struct PictureOutputs {
  std::string png;  ///< one file, or for several pictures a name with %d or %04d
  std::string mp4, webm, gif;
  [[nodiscard]] bool any() const { return !png.empty() || !mp4.empty() || !webm.empty() || !gif.empty(); }
};

/// Lets Blender write the content as FBX or Alembic, by the extension of `file` (.fbx, .abc).
/// @param glb publish::write_take_glb() @param rate frames per second @param blender program; empty: found on the path
[[nodiscard]] Result<void> export_with_blender(std::span<const std::byte> glb, double rate, const std::string& file,
                                               const std::string& blender);

/// Draws the content in a headless browser and writes the outputs. @param page text of player.html
/// Ctrl+C ends it; no incomplete file is left. @return the files written
[[nodiscard]] Result<std::vector<std::string>> export_pictures(const std::string& page, const std::string& name,
                                                               std::span<const std::byte> ugx, const PictureOptions& options,
                                                               const PictureOutputs& outputs);

}  // namespace ugoki::cli
