#pragma once
// Options and parts of `ugoki export`.

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// Options for drawing and writing pictures.
struct PictureOptions {
  int width = 1920, height = 1080;  ///< size of a picture, px
  double rate = 0;                  ///< pictures per second; 0: the frame rate of the content
  double from = 0, duration = 0;    ///< section of the content to draw, s; duration 0: to the end
  int blur = 1;                     ///< sub-frames that are averaged into one picture; 1: no motion blur
  double shutter = 0.5;             ///< fraction of the time between two pictures over which the sub-frames are spread
  bool transparent = false;         ///< transparent background; PNG only
  bool overlays = false;            ///< true: draw the root assist
  bool light = false;               ///< true: light background instead of the dark one
  std::string browser, ffmpeg;      ///< names or paths of the programs; empty: searched in PATH
  std::string inputs;               ///< text of recorded inputs, JSON; empty: none
  std::string player;               ///< folder with the parts of the player; empty: found beside this program
};

/// Files for which pictures are drawn; empty: not wanted.
struct PictureOutputs {
  std::string png;  ///< one file, or for several pictures a name with %d or %04d
  std::string mp4, webm, gif;
  [[nodiscard]] bool any() const { return !png.empty() || !mp4.empty() || !webm.empty() || !gif.empty(); }
};

/// Returns the content as an FMU. @param version of FMI: 2 or 3 @param notes [out] sentences for the user about pins that are left out
[[nodiscard]] Result<std::string> make_content_fmu(std::span<const std::byte> ugx, const std::string& name, int version,
                                                   std::vector<std::string>& notes);

/// Writes the content as FBX or Alembic with Blender. The extension of `file` (.fbx, .abc) selects the format.
/// @param glb result of publish::write_take_glb() @param rate frames per second @param blender path of Blender; empty: found on $PATH
[[nodiscard]] Result<void> export_with_blender(std::span<const std::byte> glb, double rate, const std::string& file,
                                               const std::string& blender);

/// Draws the content in a headless browser and writes the outputs. Ctrl+C ends the export and leaves no incomplete file.
/// @param page text of player.html @param check called once with the paths of the pictures of --png, before anything is drawn
/// @return paths of the files written
[[nodiscard]] Result<std::vector<std::string>> export_pictures(const std::string& page, const std::string& name,
                                                               std::span<const std::byte> ugx, const PictureOptions& options,
                                                               const PictureOutputs& outputs,
                                                               const std::function<Result<void>(const std::vector<std::string>&)>& check);

}  // namespace ugoki::cli
