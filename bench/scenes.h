// Scenes of the benchmarks, made in code so that their sizes are exact. Set-up code: nothing here is measured.
#pragma once
#include <string>
#include <vector>

#include "scene/scene.h"

namespace kinora::bench {

struct TriangleMesh {
  std::vector<float> points;  // x y z
  std::vector<int> vertices;  // three a triangle
  size_t triangleCount() const { return vertices.size() / 3; }
};

// A closed cube with bumps on its walls, seen from inside: no ray escapes, and after a bounce no two go the same way.
// About `triangles` of them (12 n^2), no vertex nearer to the middle than 0.55 * size.
TriangleMesh bumpyRoom(size_t triangles, float size);
// A square sheet of two triangles facing the camera, between (x0, y0) and (x1, y1) at depth z.
TriangleMesh sheet(float x0, float y0, float x1, float y1, float z);

// Single cubic Bezier pieces with round widths.
struct CurveSet {
  std::vector<float> controls;  // x y z radius, four control points a piece
  size_t pieceCount() const { return controls.size() / 16; }
};
// Short bent hairs scattered in a cube of half width 1 around an empty middle: rays meet one after some tenths.
CurveSet scatteredHairs(size_t pieces);

// "name=v; name=v v v": one value is a float, three are a colour.
scene::ParameterList parameters(const std::string& text);
scene::NodePtr node(const std::string& kind, const std::string& plugin, const std::string& handle,
                    const std::string& params);
scene::NetworkPtr material(const std::string& plugin, const std::string& handle, const std::string& params);

// PxrSurface with every lobe that is rendered; the second without glass.
extern const char* const kAllLobes;
extern const char* const kAllButGlass;
// kAllLobes with two PxrFractal patterns, or with four PxrTexture ones that read the given files.
scene::NetworkPtr fractalSurface();
scene::NetworkPtr texturedSurface(const std::vector<std::string>& files);
// Four small tiled mip-mapped pictures in a folder; their names.
std::vector<std::string> writePictures(const std::string& folder);

void addMesh(scene::Scene& scene, const TriangleMesh& mesh, const scene::NetworkPtr& material);
void addCurves(scene::Scene& scene, const CurveSet& curves, const scene::NetworkPtr& material);
// Camera at the origin looking along +z, one PxrRectLight above it, path tracing with 4 bounces, no roulette, no
// clamps, all channels of the core; no geometry yet.
scene::Scene emptyScene(int width, int height);

}  // namespace kinora::bench
