// Proves: what shaders ask of the renderer - textures with every option, facts of files, attributes of objects and of
// the camera, messages between layers, rays, dictionaries - has the answer that the scene gives, or a stated refusal.
#include <cmath>

#include "fixture.h"
#include "image/read_write.h"

namespace kinora::tests {
namespace {

class ShaderServiceCalls : public Shaders {
 protected:
  using Rgb = std::array<float, 3>;
  void SetUp() override {
    Shaders::SetUp();
    // four columns by two rows: red counts columns, green rows (downwards)
    picture("grid.exr", 4, 2, 3, [](int x, int y, int c) { return c == 0 ? x * 0.25f : c == 1 ? y * 0.5f : 0.125f; });
    picture("grey.exr", 4, 2, 1, [](int, int, int) { return 0.25f; });
  }
  template <class F>
  void picture(const std::string& name, int width, int height, int channels, F&& value) {
    image::Image p({0, 0, width, height}, {{channels == 1 ? "Y" : "R"}});
    p.channels.resize(0);
    static const char* const kNames[] = {"R", "G", "B", "A"};
    for (int c = 0; c < channels; ++c) p.channels.push_back({channels == 1 ? "Y" : kNames[c]});
    p.pixels.clear();
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < channels; ++c) p.pixels.push_back(value(x, y, c));
    ASSERT_TRUE(image::write(folder_ + "/" + name, p).ok());
  }
  // The body of a shader whose `result` is shown.
  RenderRequest requestFor(const std::string& body, const std::string& before = "",
                           const std::string& primvars = "") {
    write("asks.osl", "shader asks(float s = u, float t = v, output color result = 0) { " + body + " }");
    RenderRequest r = requestOf(before + "Pattern \"asks\" \"n\"\n" + kShow, primvars);
    r.settings.texturePath = {folder_};
    return r;
  }
  Rgb asked(const std::string& body, const std::string& before = "", const std::string& primvars = "") {
    SceneRender render(requestFor(body, before, primvars));
    for (const std::string& m : render.messages()) ADD_FAILURE() << m;
    return middleOf(render);
  }
};

// A slip in the name of a coordinate system is told once, whoever asks, and changes nothing else.
TEST_F(ShaderServiceCalls, CoordinateSystemsThatNothingNames) {
  SceneRender render(
      requestFor("matrix m; result = color(getmatrix(\"wurld\", \"common\", m), "
                 "transform(\"wurld\", point(.25, 0, 0))[0], getmatrix(\"world\", \"common\", m));"));
  EXPECT_EQ(told(render, "SHADER-COORDSYS"), 1u);
  EXPECT_EQ(middleOf(render), (Rgb{0, .25f, 1}));
}

TEST_F(ShaderServiceCalls, TextureOptions) {
  const auto at = [&](const std::string& arguments) {
    return asked("result = texture(\"grid.exr\", " + arguments + ", \"width\", 0, \"interp\", \"closest\");");
  };
  EXPECT_EQ(at("0.375, 0.25"), (Rgb{.25f, 0, .125f}));
  EXPECT_EQ(at("0.375, 0.75"), (Rgb{.25f, .5f, .125f}));
  // outside
  EXPECT_EQ(at("1.375, 0.25, \"wrap\", \"periodic\""), (Rgb{.25f, 0, .125f}));
  EXPECT_EQ(at("1.375, 0.25, \"wrap\", \"clamp\""), (Rgb{.75f, 0, .125f}));
  EXPECT_EQ(at("1.375, 0.25, \"wrap\", \"mirror\""), (Rgb{.5f, 0, .125f}));
  EXPECT_EQ(at("1.375, 0.25, \"wrap\", \"black\""), (Rgb{0, 0, 0}));
  EXPECT_EQ(at("1.375, 1.25, \"swrap\", \"clamp\", \"twrap\", \"periodic\""), (Rgb{.75f, 0, .125f}));
  // options that differ from point to point
  SceneRender halves(
      requestFor("string how = P[0] < 0 ? \"periodic\" : \"clamp\"; string file = P[1] > 0 ? \"grid.exr\" : "
                 "\"grey.exr\"; result = "
                 "texture(file, 1.375, 0.25, \"wrap\", how, \"width\", 0, \"interp\", \"closest\");"));
  const image::Image p = halves.channel("Ci");
  EXPECT_EQ(p.at(3, 3)[0], .25f);
  EXPECT_EQ(p.at(12, 3)[0], .75f);
  EXPECT_EQ(p.at(3, 12)[0] + p.at(12, 12)[0], .5f);
  // channels
  EXPECT_EQ(at("0.375, 0.75, \"firstchannel\", 1"), (Rgb{.5f, .125f, 0}));
  EXPECT_EQ(at("0.375, 0.75, \"firstchannel\", 1, \"fill\", 2"), (Rgb{.5f, .125f, 2}));
  EXPECT_EQ(asked("result = texture(\"grey.exr\", .5, .5, \"wrap\", \"clamp\", \"fill\", .75);"),
            (Rgb{.25f, .75f, .75f}));
  EXPECT_EQ(asked("float a = 9; float x = texture(\"grid.exr\", .375, .75, \"alpha\", a, \"width\", 0, \"interp\", "
                  "\"closest\"); "
                  "result = color(x, a, 0);"),
            (Rgb{.25f, .5f, 0}));
  EXPECT_EQ(
      asked("float a = 9; result = texture(\"grey.exr\", .5, .5, \"wrap\", \"clamp\", \"alpha\", a); result[1] = a;"),
      (Rgb{.25f, 1, .25f}));
  // what is not there is told in words
  const std::string lost =
      "string why = \"\"; float a = 0; result = texture(\"lost.exr\", s, t, \"missingcolor\", color(1, 2, 3), "
      "\"missingalpha\", .5, "
      "\"alpha\", a, \"errormessage\", why); if (why == \"\") result = 0; result[2] = a;";
  SceneRender missing(requestFor(lost));
  EXPECT_EQ(told(missing, "ASSET-TEXTURE-MISSING"), 1u);
  EXPECT_EQ(middleOf(missing), (Rgb{1, 2, .5f}));
  EXPECT_EQ(asked("string why = \"x\"; result = texture(\"grey.exr\", .5, .5, \"wrap\", \"clamp\", \"errormessage\", "
                  "why); result[1] = "
                  "why == \"\";"),
            (Rgb{.25f, 1, .25f}));
}

TEST_F(ShaderServiceCalls, TexturesHaveDerivatives) {
  // a ramp of 64 columns: a sixteenth of the picture is a sixteenth of its height
  picture("ramp.exr", 64, 64, 3, [](int x, int, int) { return (float(x) + 0.5f) / 64; });
  const Rgb c =
      asked("float h = texture(\"ramp.exr\", s, t, \"width\", 0); result = color(filterwidth(h) * 16, 0, 0);");
  EXPECT_NEAR(c[0], 1, 0.02);
}

// A line of light texels read at its middle: cubic B-splines weigh it by 2/3, lines by 1.
TEST_F(ShaderServiceCalls, MagnifiedTexturesAreBicubicUnlessAskedOtherwise) {
  picture("line.exr", 8, 8, 3, [](int x, int, int) { return x == 4 ? 1.f : 0.f; });
  const auto read = [&](const std::string& options) {
    return asked("result = texture(\"line.exr\", 4.5 / 8, .5, \"width\", 0" + options + ");")[0];
  };
  EXPECT_NEAR(read(""), 2.f / 3, 1e-3);
  EXPECT_NEAR(read(", \"interp\", \"smartcubic\""), 2.f / 3, 1e-3);
  EXPECT_NEAR(read(", \"interp\", \"cubic\""), 2.f / 3, 1e-3);
  EXPECT_NEAR(read(", \"interp\", \"linear\""), 1, 1e-3);
}

// The slope of alpha is that of the picture: a ramp over 64 columns.
TEST_F(ShaderServiceCalls, AlphaHasDerivatives) {
  picture("ramp.exr", 64, 64, 4, [](int x, int, int c) { return c == 3 ? (float(x) + 0.5f) / 64 : 1.f; });
  const Rgb c = asked(
      "float a = 0; color d = texture(\"ramp.exr\", s, t, \"width\", 0, \"alpha\", a); result = color(filterwidth(a) "
      "* "
      "16, 0, 0);");
  EXPECT_NEAR(c[0], 1, 0.02);
}

TEST_F(ShaderServiceCalls, ShaderSpaceIsTheObjectsWhereNoneIsNamed) {
  const Rgb c = asked(
      "point a = transform(\"shader\", P), b = transform(\"object\", P); result = color(distance(a, b), a[2], "
      "P[2]);");
  EXPECT_EQ(c[0], 0);
  EXPECT_NEAR(c[1], 0, 1e-6);
  EXPECT_NEAR(c[2], 1, 1e-6);
}

TEST_F(ShaderServiceCalls, EnvironmentsAreLatitudeAndLongitude) {
  const auto look = [&](const std::string& direction) {
    return asked("result = environment(\"grid.exr\", vector(" + direction +
                 "), \"width\", 0, \"interp\", \"closest\");");
  };
  EXPECT_EQ(look(".1, 1, .9"), (Rgb{.25f, 0, .125f}));  // up, just before the middle
  EXPECT_EQ(look("-.1, 1, .9"), (Rgb{.5f, 0, .125f}));
  EXPECT_EQ(look("-.1, -1, -.9"), (Rgb{.75f, .5f, .125f}));
  EXPECT_EQ(look(".1, -1, -.9"), (Rgb{0, .5f, .125f}));
}

TEST_F(ShaderServiceCalls, FactsOfTextures) {
  EXPECT_EQ(asked("int n[2]; int found = gettextureinfo(\"grid.exr\", \"resolution\", n); result = color(found, "
                  "n[0], n[1]);"),
            (Rgb{1, 4, 2}));
  EXPECT_EQ(asked("int here = 9, gone = 9, n = 0; gettextureinfo(\"grid.exr\", \"exists\", here); "
                  "gettextureinfo(\"lost.exr\", "
                  "\"exists\", gone); gettextureinfo(\"grid.exr\", \"channels\", n); result = color(here, gone, n);"),
            (Rgb{1, 0, 3}));
  EXPECT_EQ(asked("color mean = 0; gettextureinfo(\"grid.exr\", \"averagecolor\", mean); result = mean;"),
            (Rgb{.375f, .25f, .125f}));
  EXPECT_EQ(
      asked("string kind = \"\"; int found = gettextureinfo(\"grid.exr\", \"type\", kind), window[4], n = 0; "
            "gettextureinfo(\"grid.exr\", \"datawindow\", window); gettextureinfo(\"grid.exr\", \"subimages\", n); "
            "result = color(found + (kind != \"\"), window[2], n);"),
      (Rgb{2, 3, 1}));
  // not to be had: nothing is written
  EXPECT_EQ(
      asked("float x = 7; int a = gettextureinfo(\"grid.exr\", \"nonsense\", x), b = gettextureinfo(\"lost.exr\", "
            "\"channels\", x); result = color(a, b, x);"),
      (Rgb{0, 0, 7}));
}

TEST_F(ShaderServiceCalls, AttributesOfObjectsAndTheCamera) {
  const std::string object =
      "Attribute \"user\" \"float wear\" [.5] \"color tint\" [.1 .2 .3] \"string label\" [\"hero\"] \"int count\" "
      "[3] \"float[2] pair\" "
      "[5 6]\nAttribute \"identifier\" \"string name\" [\"square\"]\n";
  EXPECT_EQ(
      asked("float w = 0; int n = 0; float c = 0; getattribute(\"user:wear\", w); getattribute(\"user:count\", n); "
            "getattribute(\"user:count\", c); result = color(w, n, c);",
            object),
      (Rgb{.5f, 3, 3}));
  EXPECT_EQ(asked("getattribute(\"user:tint\", result);", object), (Rgb{.1f, .2f, .3f}));
  EXPECT_EQ(asked("getattribute(\"user:wear\", result);", object), (Rgb{.5f, .5f, .5f}));
  EXPECT_EQ(asked("string l = \"\"; getattribute(\"user:label\", l); string name = \"\"; "
                  "getattribute(\"identifier:name\", name); "
                  "float x = 0; int found = getattribute(\"user:pair\", 1, x); result = color(l == \"hero\", name == "
                  "\"square\", x * found);",
                  object),
            (Rgb{1, 1, 6}));
  EXPECT_EQ(asked("float x = 7; string l = \"\"; result = color(getattribute(\"user:none\", x), "
                  "getattribute(\"user:wear\", l), x);",
                  object),
            (Rgb{0, 0, 7}));
  // primvars come first, and each object has its own
  EXPECT_EQ(asked("float w = 0; point p = 0; getattribute(\"wear\", w); int found = getattribute(\"place\", p); "
                  "result = color(w, p[2], found);",
                  "", "\"constant float wear\" [.25] \"constant point place\" [0 0 2]"),
            (Rgb{.25f, 3, 1}));  // the square stands at z = 1
  EXPECT_EQ(asked("int n[2] = {0, 0}; float fov = -1; string kind = \"\"; getattribute(\"camera:resolution\", n); "
                  "getattribute(\"camera:projection\", kind); int has = getattribute(\"camera:fov\", fov); "
                  "result = color(n[0] + n[1], kind == \"orthographic\", has);"),
            (Rgb{32, 1, 0}));
  EXPECT_EQ(asked("float w[4] = {0, 0, 0, 0}, shut[2] = {9, 9}; getattribute(\"camera:screen_window\", w); "
                  "getattribute(\"camera:shutter\", shut); result = color(w[2], w[3], shut[1]);"),
            (Rgb{1, 1, 0}));
  EXPECT_EQ(asked("string shader = \"\", layer = \"\"; int version = 0; getattribute(\"shader:shadername\", shader); "
                  "getattribute(\"shader:layername\", layer); getattribute(\"osl:version\", version); "
                  "result = color(shader == \"asks\", layer == \"n\", version >= 11400);"),
            (Rgb{1, 1, 1}));
  const Rgb n = asked(
      "normal n = 0; point p = 0; getattribute(\"builtin\", \"Nn\", n); getattribute(\"builtin\", \"P\", p); "
      "result = color(n[2], p[2], getattribute(\"builtin\", \"nonsense\", n));");
  EXPECT_NEAR(n[0], -1, 1e-6);
  EXPECT_NEAR(n[1], 1, 1e-6);
  EXPECT_EQ(n[2], 0);
}

TEST_F(ShaderServiceCalls, ElementsAndStringsOfPrimvars) {
  const std::string primvars =
      "\"constant float[3] list\" [.1 .2 .3] \"constant color tint\" [.4 .5 .6] "
      "\"constant color[2] tints\" [1 2 3 4 5 6] \"constant int[2] ids\" [7 9] \"constant string label\" [\"hero\"] "
      "\"uniform string[2] kinds\" [\"a\" \"b\"] "
      "\"vertex float[4] wide\" [1 2 3 -1  1 2 3 -1  1 2 3 1  1 2 3 1]";
  EXPECT_EQ(asked("float a = 0, b = 0; color whole = 0; getattribute(\"list\", 1, a); getattribute(\"tint\", 2, b); "
                  "getattribute(\"tint\", 0, whole); result = color(a, b, whole[1]);",
                  "", primvars),
            (Rgb{.2f, .6f, .5f}));
  EXPECT_EQ(asked("getattribute(\"tints\", 1, result);", "", primvars), (Rgb{4, 5, 6}));
  EXPECT_EQ(asked("float x = 7; result = color(getattribute(\"list\", 3, x), getattribute(\"list\", -1, x), x);", "",
                  primvars),
            (Rgb{0, 0, 7}));
  EXPECT_EQ(
      asked("string l = \"\", k = \"\"; int n[2] = {0, 0}; getattribute(\"label\", l); getattribute(\"kinds\", 1, "
            "k); getattribute(\"ids\", n); result = color(l == \"hero\", k == \"b\", n[1]);",
            "", primvars),
      (Rgb{1, 1, 9}));
  EXPECT_EQ(
      asked("float one = -1, both[2] = {-1, -1}; getattribute(\"st\", 1, one); getattribute(\"st\", both); result = "
            "color(one == both[1], one > 0, 0);"),
      (Rgb{1, 1, 0}));
  // wider than three and between vertices: the last is x
  const Rgb wide = asked(
      "float w[4] = {0, 0, 0, 0}, last = 0; getattribute(\"wide\", w); getattribute(\"wide\", 3, last); "
      "result = color(w[2], w[3] - P[0], last - P[0]);",
      "", primvars);
  EXPECT_NEAR(wide[0], 3, 1e-5);
  EXPECT_NEAR(wide[1], 0, 1e-5);
  EXPECT_NEAR(wide[2], 0, 1e-5);
}

TEST_F(ShaderServiceCalls, MessagesRaysAndSurfaces) {
  write("first.osl", "shader first(output color result = 0) { setmessage(\"said\", 3.0); result = 1; }");
  write("second.osl",
        "shader second(color a = 0, output color result = 0) { float x = 0; color b = a; int found = "
        "getmessage(\"said\", x); result "
        "= color(found, x, b[0]); }");
  SceneRender render(
      requestOf("Pattern \"first\" \"f\"\nPattern \"second\" \"n\" \"reference color a\" [\"f:result\"]\n" +
                std::string(kShow)));
  EXPECT_TRUE(render.messages().empty());
  EXPECT_EQ(middleOf(render), (Rgb{1, 3, 1}));
  EXPECT_EQ(asked("result = color(raytype(\"camera\"), raytype(\"shadow\"), raytype(\"diffuse\"));"), (Rgb{1, 0, 0}));
  EXPECT_NEAR(asked("result = surfacearea();")[0], 4, 1e-5);
  // asked at some of the points, the others keep what they had
  EXPECT_EQ(
      asked("int a = 5, b = 5; if (u > 2) { a = raytype(\"camera\"); b = backfacing(); } result = color(a, b, 1);"),
      (Rgb{5, 5, 1}));
  SceneRender halves(requestFor("int a = 5; if (P[0] > 0) a = raytype(\"camera\"); result = a;"));
  const image::Image picture = halves.channel("Ci");
  EXPECT_EQ(picture.at(2, 8)[0] + picture.at(13, 8)[0], 6);
  EXPECT_EQ(asked("int n = dict_find(\"<a><b x='2.5'/></a>\", \"//b\"); float x = 0; int found = dict_value(n, "
                  "\"x\", x); result = "
                  "color(n > 0, found, x);"),
            (Rgb{1, 1, 2.5f}));
}

// What an enclosing sphere says of the rays that reach it from a square in its middle.
TEST_F(ShaderServiceCalls, RayTypesOfPaths) {
  const auto shader = [&](const char* type, const std::string& value) {
    write("asks.osl", "shader asks(output " + std::string(type) + " result = 0) { result = " + value + "; }");
  };
  const auto seen = [&](const std::string& material, const std::string& red, const std::string& green,
                        const std::string& blue) {
    shader("color", "color(raytype(\"" + red + "\"), raytype(\"" + green + "\"), raytype(\"" + blue + "\"))");
    RenderRequest request = requestOf("AttributeBegin\nPattern \"asks\" \"n\"\n" + std::string(kShow) +
                                      "Sphere 10 -10 10 360\nAttributeEnd\n" + material);
    request.settings.samplesPerPixel = 16;
    SceneRender render(request);
    EXPECT_TRUE(render.messages().empty()) << render.messages()[0];
    const image::Image picture = render.channel("Ci");
    Rgb mean{};
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x)
        for (size_t c = 0; c < 3; ++c) mean[c] += picture.at(x, y)[c] / 256;
    return mean;
  };
  const std::string matte = "Bxdf \"PxrDiffuse\" \"m\" \"color diffuseColor\" [1 1 1]\n";
  const Rgb diffuse = seen(matte, "diffuse", "reflection", "camera");
  EXPECT_NEAR(diffuse[0], 1, 1e-5);
  EXPECT_EQ(diffuse[1] + diffuse[2], 0);
  EXPECT_EQ(seen(matte, "specular", "glossy", "shadow"), (Rgb{0, 0, 0}));
  // through one sheet into the glass, where radiance is smaller by the square of the index: 0.96 / 1.5^2
  const std::string glass = "Bxdf \"PxrGlass\" \"m\" \"float roughness\" ";
  const Rgb clear = seen(glass + "[0]\n", "reflection", "refraction", "singular");
  EXPECT_NEAR(clear[0], 0.04f, 0.015f);  // 4,096 samples: sigma is 0.003
  EXPECT_NEAR(clear[1], 0.96f / 2.25f, 0.007f);
  EXPECT_NEAR(clear[2], clear[0] + clear[1], 1e-5);
  EXPECT_EQ(seen(glass + "[0]\n", "glossy", "diffuse", "camera"), (Rgb{0, 0, 0}));
  const Rgb rough = seen(glass + "[.4]\n", "glossy", "specular", "singular");
  EXPECT_GT(rough[0], 0.3f);
  EXPECT_EQ(rough[0], rough[1]);
  EXPECT_EQ(rough[2], 0);
  // there for one type of ray only: what only shadow rays see darkens, what others see does not
  for (const char* type : {"shadow", "transmission", "diffuse", "specular"}) {
    shader("float", "raytype(\"" + std::string(type) + "\")");
    RenderRequest request = requestOf(
        "AttributeBegin\nPattern \"asks\" \"n\"\n"
        "Bxdf \"PxrDiffuse\" \"m\" \"reference float presence\" [\"n:result\"]\n"
        "Sphere .5 -.5 .5 360\nAttributeEnd\n" +
        matte);
    const std::string dome = "Light \"PxrDomeLight\" \"sky\"";
    request.rib.replace(request.rib.find(dome), dome.size(), "Light \"PxrDistantLight\" \"sun\"");
    SceneRender render(request);
    EXPECT_TRUE(render.messages().empty()) << render.messages()[0];
    // more shadow rays than paths
    request.rib.insert(0, "Integrator \"PxrPathTracer\" \"i\" \"int numLightSamples\" [64]\n");
    SceneRender many(request);
    EXPECT_EQ(middleOf(many)[0] > 0, middleOf(render)[0] > 0) << type;
    const bool isShadow = std::string(type) == "shadow" || std::string(type) == "transmission";
    EXPECT_EQ(middleOf(render)[0] > 0, !isShadow) << type;
  }
}

TEST_F(ShaderServiceCalls, WhatIsNotGrantedIsToldOnce) {
  SceneRender traced(requestFor("result = color(.5, trace(P, N), trace(P, -N));"));
  EXPECT_EQ(traced.messages().size(), 1u);
  EXPECT_EQ(told(traced, "SHADER-CALL"), 1u);
  EXPECT_EQ(middleOf(traced), (Rgb{.5f, 0, 0}));
  SceneRender cloud(requestFor("int i[2]; result = pointcloud_search(\"c\", P, 1, 2, \"index\", i);"));
  ASSERT_FALSE(cloud.messages().empty());
  EXPECT_NE(cloud.messages()[0].find("pointcloud_search"), std::string::npos) << cloud.messages()[0];
}

TEST_F(ShaderServiceCalls, ClosuresAndDisplacements) {
  write("lit.osl", "surface lit(output color result = 0) {\n  result = .5;\n  Ci = diffuse(N) + emission();\n}");
  SceneRender lit(requestOf("Pattern \"lit\" \"n\"\n" + std::string(kShow)));
  ASSERT_EQ(lit.messages().size(), 1u);
  EXPECT_NE(lit.messages()[0].find("lit.osl:3: warning SHADER-CLOSURE: closure diffuse() of shader 'lit'"),
            std::string::npos)
      << lit.messages()[0];
  EXPECT_EQ(middleOf(lit), (Rgb{.5f, .5f, .5f}));
  write("bumps.osl", "displacement bumps(float height = .1) { P += N * height * noise(P); }");
  SceneRender displaced(
      requestOf("Displace \"bumps\" \"d\"\nBxdf \"PxrConstant\" \"m\" \"color emitColor\" [1 1 1]\n"));
  EXPECT_TRUE(displaced.messages().empty()) << displaced.messages()[0];
  EXPECT_GT(displaced.renderer().statistics().micropolygons, 0u);
  EXPECT_EQ(displaced.renderer().statistics().shadersCompiled, 1u);
  write("still.osl", "displacement still(output color seen = 0) { seen = noise(P); }");
  SceneRender still(requestOf("Displace \"still\" \"d\"\nBxdf \"PxrConstant\" \"m\" \"color emitColor\" [1 1 1]\n"));
  ASSERT_EQ(still.messages().size(), 1u);
  EXPECT_NE(still.messages()[0].find("SHADER-DISPLACEMENT"), std::string::npos) << still.messages()[0];
  write("broken.osl", "displacement broken() { P += nothing; }");
  SceneRender broken(
      requestOf("Displace \"broken\" \"d\"\nBxdf \"PxrConstant\" \"m\" \"color emitColor\" [1 1 1]\n"));
  EXPECT_EQ(told(broken, "SHADER-COMPILE"), 1u);
}

}  // namespace
}  // namespace kinora::tests
