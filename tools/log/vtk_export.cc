#include "tools/log/vtk_export.h"

#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "engine/base/error.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/logged_surface.h"
#include "tools/log/file_names.h"
#include "tools/shared/base64.h"
#include "tools/shared/mesh_parts.h"
#include "tools/shared/report_text.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little);

/// Returns a DataArray of VTK's XML formats: the number of bytes and the numbers, in base64.
template <typename Number>
std::string DataArray(const std::string& attributes, const std::vector<Number>& numbers) {
  const auto size = static_cast<std::uint64_t>(numbers.size() * sizeof(Number));
  std::vector<std::byte> bytes(sizeof size + size);
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, numbers.data(), size);
  return "<DataArray " + attributes + " format=\"binary\">" + Base64(bytes) + "</DataArray>\n";
}

std::vector<float> Floats(const Points& points) {
  return {points.data(), points.data() + points.size()};
}

std::string PolyData(const Points& vertices, const Points& rest, const Triangles& triangles) {
  constexpr char kVectors[] = "type=\"Float32\" NumberOfComponents=\"3\" Name=";
  std::vector<std::int32_t> corners(triangles.data(), triangles.data() + triangles.size()), ends;
  for (std::int32_t end = 3; end <= static_cast<std::int32_t>(corners.size()); end += 3) {
    ends.push_back(end);
  }
  return Format(
             "<?xml version=\"1.0\"?>\n"
             "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
             "header_type=\"UInt64\">\n<PolyData>\n"
             "<Piece NumberOfPoints=\"%ld\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
             "NumberOfStrips=\"0\" NumberOfPolys=\"%ld\">\n",
             static_cast<long>(vertices.rows()), static_cast<long>(triangles.rows())) +
         "<Points>\n" + DataArray(std::string(kVectors) + "\"Points\"", Floats(vertices)) +
         "</Points>\n<PointData Vectors=\"displacement\">\n" +
         DataArray(std::string(kVectors) + "\"displacement\"", Floats(vertices - rest)) +
         "</PointData>\n<Polys>\n" + DataArray("type=\"Int32\" Name=\"connectivity\"", corners) +
         DataArray("type=\"Int32\" Name=\"offsets\"", ends) +
         "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
}

std::string Seconds(std::int64_t nanoseconds) {
  std::array<char, 32> digits;
  const double seconds = static_cast<double>(nanoseconds) / 1e9;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), seconds).ptr};
}

class VtkExport {
 public:
  explicit VtkExport(fs::path folder) : folder_(std::move(folder)) {}

  void Take(mesh_t&& part) {
    if (part.organ < 0 || part.organ >= kMaxOrgans) return;
    Organ& organ = organs_[part.organ];
    // A live session repeats its meshes; the first one counts.
    if (organ.surface || !organ.parts.Take(std::move(part))) return;
    organ.surface.emplace(*organ.parts.whole());
    organ.exported.name = organ.surface->organ().name;
    organ.file_stem = names_.Of(organ.exported.name);
    WriteSurface(0, organ.surface->organ().vertices, &organ);
  }

  void Take(organ_t&& message) {
    if (message.organ < 0 || message.organ >= kMaxOrgans) return;
    Organ& organ = organs_[message.organ];
    OrganSnapshot shape;
    Points vertices;
    if (!organ.surface || message.step < steps_.back().number || !FromMessage(message, &shape) ||
        !organ.surface->Deform(shape, &vertices)) {
      ++organ.exported.skipped;
      return;
    }
    if (message.step > steps_.back().number) steps_.push_back({message.step, message.time_ns});
    // An organ at rest is sent again and again.
    message.sequence = message.step = message.time_ns = 0;
    std::vector<std::uint8_t> encoded;
    EncodeMessage(message, &encoded);
    if (encoded == organ.newest) return;
    organ.newest = std::move(encoded);
    WriteSurface(steps_.back().number, vertices, &organ);
  }

  ExportedSurfaces Finish(const std::string& log) {
    if (files_.empty()) {
      throw InputError(log + ": contains no surfaces; give the log of a session");
    }
    ExportedSurfaces exported{folder_ / "surfaces.pvd", steps_.size() - 1, {}};
    WriteIndex(exported.index);
    for (StagedFile& file : files_) file.Commit();
    for (auto& [number, organ] : organs_) exported.organs.push_back(organ.exported);
    return exported;
  }

 private:
  struct Organ {
    MeshParts parts;
    std::optional<LoggedSurface> surface;
    std::vector<std::uint8_t> newest;  ///< The newest shape's message, without step and time.
    std::string file_stem;
    std::map<std::int64_t, std::string> files;  ///< By step.
    ExportedOrgan exported;
  };
  struct Step {
    std::int64_t number;
    std::int64_t time_ns;
  };

  void WriteSurface(std::int64_t step, const Points& vertices, Organ* organ) {
    const std::string name = organ->file_stem + Format("_%06lld.vtp", static_cast<long long>(step));
    const OrganDescription& rest = organ->surface->organ();
    if (!organ->files.emplace(step, name).second) return;  // two shapes of one step
    files_.emplace_back(folder_ / name, StagedFile::Name::kOfOthers);
    files_.back().Write(PolyData(vertices, rest.vertices, rest.triangles));
    files_.back().Rest();
    ++organ->exported.surfaces;
  }

  void WriteIndex(const fs::path& path) {
    std::string text =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
        "<Collection>\n";
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const Step& step = steps_[i];
      // A time has one data set: the first step replaces the rest shapes, which have time 0 too.
      if (i + 1 < steps_.size() && steps_[i + 1].time_ns == step.time_ns) continue;
      for (const auto& [number, organ] : organs_) {
        const auto next = organ.files.upper_bound(step.number);
        if (next == organ.files.begin()) continue;
        text += "<DataSet timestep=\"" + Seconds(step.time_ns) + "\" part=\"" +
                std::to_string(number) + "\" file=\"" + std::prev(next)->second + "\"/>\n";
      }
    }
    files_.emplace_back(path, StagedFile::Name::kOfOthers);
    files_.back().Write(text + "</Collection>\n</VTKFile>\n");
    files_.back().Close();
  }

  fs::path folder_;
  FileNames names_;
  std::map<std::int32_t, Organ> organs_;  // by number
  std::vector<Step> steps_ = {{0, 0}};    // step 0: the rest shapes
  std::vector<StagedFile> files_;
};

}  // namespace

ExportedSurfaces ExportVtk(const std::string& log, const fs::path& folder,
                           const std::function<void()>& at_event) {
  LogReader reader(log);
  MakeOutFolder(folder);
  VtkExport out(folder);
  LogEvent event;
  while (reader.Next(&event)) {
    at_event();
    mesh_t part;
    organ_t shape;
    if (event.channel == kMeshChannel && DecodeMessage(event.data, &part)) {
      out.Take(std::move(part));
    } else if (event.channel == kOrganChannel && DecodeMessage(event.data, &shape)) {
      out.Take(std::move(shape));
    }
  }
  return out.Finish(log);
}

}  // namespace hpdm
