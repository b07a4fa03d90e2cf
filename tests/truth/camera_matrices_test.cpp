// Proves: a picture's own words about its camera are true. The points of a wall, which the picture holds pixel by
// pixel (channel P), are projected by the matrices in the file and come to lie in their pixels, for every projection,
// screen window, crop, resolution, pixel aspect and lens shift; the way back leads to the points; the screen window
// is where the picture lies at distance 1. Misses: cameras that move or zoom, of which a file has the middle alone.
#include <ImfArray.h>
#include <ImfFloatAttribute.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfMatrixAttribute.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "image/read_write.h"
#include "support/render_scene.h"

namespace kinora::tests {
namespace {

struct Camera {
  const char* name;
  std::string requests;  // before the camera's transform
  std::array<int, 2> resolution{0, 0};
  std::array<float, 4> crop{-1, -1, -1, -1};
  bool isPerspective = true;
  std::string transform = "Rotate 12 0 0 1 Rotate -20 0 1 0 Translate 1 -0.5 6";
  std::string place = "";  // of the wall
};

// A wall of hills far beyond what any of the cameras sees.
std::string wall(const Camera& c) {
  std::string mesh = "PointsPolygons [";
  constexpr int kSide = 8;
  std::string indices, points;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const int at = j * (kSide + 1) + i;
      mesh += "4 ";
      for (const int k : {at, at + 1, at + kSide + 2, at + kSide + 1}) indices += std::to_string(k) + " ";
    }
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i <= kSide; ++i)
      points += std::to_string(20 * (i - kSide / 2)) + " " + std::to_string(20 * (j - kSide / 2)) + " " +
                std::to_string(3 * ((i * 7 + j * 5) % 3)) + " ";
  mesh += "] [" + indices + "] \"P\" [" + points + "]\n";
  return "PixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [1] \"int jitter\" [0]\n" + c.requests +
         "\n" + c.transform + "\nWorldBegin\n" + c.place +
         "\nBxdf \"PxrConstant\" \"c\" \"color emitColor\" [1 1 1]\n" + mesh + "WorldEnd\n";
}

Imath::M44d matrixOf(const Imf::Header& header, const char* name) {
  const auto* a = header.findTypedAttribute<Imf::M44fAttribute>(name);
  EXPECT_TRUE(a) << name;
  return a ? Imath::M44d(a->value()) : Imath::M44d();
}

TEST(CameraMatrices, ProjectThePointsOfThePictureIntoTheirPixels) {
  const std::string perspective = "Projection \"perspective\" \"fov\" [40]",
                    orthographic = "Projection \"orthographic\"";
  const Camera cameras[] = {
      {"perspective", "Format 48 32 1\n" + perspective},
      {"tall", "Format 24 40 1\n" + perspective},
      {"pixel aspect", "Format 40 30 1.6\n" + perspective},
      {"window off centre", "Format 40 40 1\nScreenWindow -0.2 0.9 0.1 1.2\n" + perspective},
      {"mirrored window", "Format 40 40 1\nScreenWindow 1 -1 -1 1\n" + perspective},
      {"crop of the scene", "Format 40 30 1\nCropWindow 0.2 0.7 0.5 0.9\n" + perspective},
      {"crop of the command", "Format 40 30 1\n" + perspective, {0, 0}, {0.1f, 0.5f, 0.3f, 0.8f}},
      {"resolution of the command", "Format 400 300 1\n" + perspective, {32, 24}},
      {"clipping", "Format 40 30 1\nClipping 0.5 1000\n" + perspective},
      {"near plane at the eye, far from the origin",
       "Format 40 30 1\nClipping 0.0001 1e6\n" + perspective,
       {0, 0},
       {-1, -1, -1, -1},
       true,
       "Translate 0 0 20 Rotate 9 0 1 0 Translate -4000 0 0",
       "Translate 4000 0 0"},
      {"lens shift and roll",
       "Format 40 30 1\nProjection \"PxrCamera\" \"float fov\" [50] \"float shiftX\" [0.3] \"float shiftY\" [-0.2] "
       "\"float roll\" [25]"},
      {"orthographic", "Format 48 32 1\nScreenWindow -3 3 -2 2\n" + orthographic, {0, 0}, {-1, -1, -1, -1}, false},
      {"orthographic off centre",
       "Format 40 40 1\nScreenWindow 1 9 -3 5\nClipping 1 200\n" + orthographic,
       {0, 0},
       {0.25f, 0.75f, 0.5f, 1},
       false},
  };
  const std::string file =
      (std::filesystem::temp_directory_path() / ("kinora_camera_" + std::to_string(getpid()) + ".exr")).string();
  for (const Camera& camera : cameras) {
    SCOPED_TRACE(camera.name);
    RenderRequest q;
    q.rib = wall(camera);
    q.channels = "Ci,a,P";
    q.settings.output = file;
    q.settings.resolution = camera.resolution;
    q.settings.crop = camera.crop;
    SceneRender r(q);
    ASSERT_TRUE(r.ok());
    ASSERT_EQ(r.renderer().render(), render::Outcome::Complete);
    image::Image all;
    ASSERT_TRUE(image::read(file, all).ok());
    const std::string base = std::filesystem::path(file).stem().string();
    const Imf::InputFile in(file.c_str());
    const Imf::Header& header = in.header();
    const Imath::M44d toNdc = matrixOf(header, "worldToNDC"), toCamera = matrixOf(header, "worldToCamera");
    EXPECT_EQ(matrixOf(header, "worldtoNDC"), toNdc) << "RenderMan's name of it";
    EXPECT_EQ(matrixOf(header, "worldtocamera"), toCamera);
    const Imath::M44d back = toNdc.inverse();
    const double width = all.display.width(), height = all.display.height();
    const double windowWidth = double(header.screenWindowWidth()),
                 windowHeight = windowWidth * height / (width * double(header.pixelAspectRatio()));
    const Imath::V2f centre = header.screenWindowCenter();
    const int px = all.findChannel("P.X"), alpha = all.findChannel("A");
    ASSERT_GE(px, 0);
    ASSERT_GE(alpha, 0);
    int seen = 0;
    for (int y = all.data.y0; y < all.data.y1; ++y)
      for (int x = all.data.x0; x < all.data.x1; ++x) {
        if (all.at(x, y)[alpha] != 1) continue;
        ++seen;
        const float* p = all.at(x, y) + px;
        const double P[4] = {double(p[0]), double(p[1]), double(p[2]), 1};
        double clip[4] = {}, eye[3] = {};
        for (int k = 0; k < 4; ++k)
          for (int i = 0; i < 4; ++i) clip[k] += P[i] * toNdc[i][k];
        for (int k = 0; k < 3; ++k)
          for (int i = 0; i < 4; ++i) eye[k] += P[i] * toCamera[i][k];
        // pixels have their centres at halves; a hundredth of a pixel is the floats' of P far from the origin
        EXPECT_NEAR(clip[0] / clip[3] * width, x + 0.5, 0.02) << x << " " << y;
        EXPECT_NEAR(clip[1] / clip[3] * height, y + 0.5, 0.02) << x << " " << y;
        EXPECT_GT(eye[2], 0);
        double world[4] = {};
        for (int k = 0; k < 4; ++k)
          for (int i = 0; i < 4; ++i) world[k] += clip[i] / clip[3] * back[i][k];
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(world[k] / world[3], P[k], 1e-6 * (1 + std::fabs(eye[2])));
        // OpenEXR: x to the left, y up, on the plane at distance 1
        const double depth = camera.isPerspective ? eye[2] : 1;
        const double left = -eye[0] / depth, up = eye[1] / depth;
        if (std::string(camera.name) == "mirrored window" || std::string(camera.name) == "lens shift and roll")
          continue;
        EXPECT_NEAR(0.5 - (left - double(centre.x)) / windowWidth, (x + 0.5) / width, 2e-3) << x << " " << y;
        EXPECT_NEAR(0.5 - (up - double(centre.y)) / windowHeight, (y + 0.5) / height, 2e-3) << x << " " << y;
      }
    EXPECT_GT(seen, 100);
    std::filesystem::remove(file);
    for (const auto& e : std::filesystem::directory_iterator(std::filesystem::temp_directory_path()))
      if (e.path().filename().string().starts_with(base)) std::filesystem::remove(e.path());
  }
}

}  // namespace
}  // namespace kinora::tests
