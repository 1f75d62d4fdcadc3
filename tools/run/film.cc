#include "tools/run/film.h"

#include "engine/base/error.h"
#include "tools/shared/child_process.h"
#include "tools/shared/report_text.h"

namespace hpdm {

std::string MakeFilm(const std::filesystem::path& frames, double fps,
                     const std::filesystem::path& film) {
  const std::string rate = Format("%g", fps);
  std::string pattern = "file:";  // so that ffmpeg takes no name for an option or a protocol
  for (const char c : frames.string()) pattern += c == '%' ? "%%" : std::string(1, c);
  pattern += "/frame_%06d.png";
  int exit_code = 0;
  try {
    // The usual 4:2:0 sampling needs even sides.
    exit_code = RunChild({"ffmpeg",
                          "-nostdin",
                          "-y",
                          "-framerate",
                          rate,
                          "-i",
                          pattern,
                          "-vf",
                          "pad=ceil(iw/2)*2:ceil(ih/2)*2",
                          "-c:v",
                          "libx264",
                          "-preset",
                          "veryfast",
                          "-crf",
                          "20",
                          "-pix_fmt",
                          "yuv420p",
                          "-movflags",
                          "+faststart",
                          "file:" + film.string()});
  } catch (const MachineError& error) {
    return std::string("not made (") + error.what() +
           "); install the package ffmpeg; the frames are in " + frames.string();
  }
  if (exit_code == 0) return {};
  std::error_code ignored;
  std::filesystem::remove(film, ignored);  // half a film
  return Format("not made (ffmpeg exited with %d); the frames are in ", exit_code) +
         frames.string();
}

}  // namespace hpdm
