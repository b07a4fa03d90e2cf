// Proves: a shader is compiled once while a scene is edited, and again when one of its files has changed, which is
// told; nothing is written beside a source unless the scene asks for it, and what was written is read instead of a
// source that is older.
#include "fixture.h"

namespace kinora::tests {
namespace {

namespace fs = std::filesystem;

class ShaderFiles : public Shaders {
 protected:
  std::array<float, 3> again(SceneRender& render) {
    EXPECT_TRUE(render.renderer().update());
    render.renderer().renderFilm();
    return middleOf(render);
  }
  bool exists(const std::string& name) { return fs::exists(folder_ + "/" + name); }
  void age(const std::string& name, int seconds) {
    fs::last_write_time(folder_ + "/" + name, fs::file_time_type::clock::now() - std::chrono::seconds(seconds));
  }
  const std::string network_ = std::string("Pattern \"shown\" \"n\"\n") + kShow;
  using Rgb = std::array<float, 3>;
};

TEST_F(ShaderFiles, AShaderIsCompiledOnceAndAgainWhenItsFileChanges) {
  write("shown.osl", "shader shown(output color result = 0) { result = .25; }");
  SceneRender render(requestOf(network_));
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(middleOf(render), (Rgb{.25f, .25f, .25f}));
  EXPECT_EQ(render.renderer().statistics().shadersCompiled, 1u);
  EXPECT_EQ(again(render), (Rgb{.25f, .25f, .25f}));
  EXPECT_EQ(render.renderer().statistics().shadersCompiled, 1u);
  EXPECT_TRUE(render.messages().empty());
  // the same length, within a tick of the clock
  write("shown.osl", "shader shown(output color result = 0) { result = .75; }");
  EXPECT_EQ(again(render), (Rgb{.75f, .75f, .75f}));
  EXPECT_EQ(render.renderer().statistics().shadersCompiled, 2u);
  EXPECT_EQ(told(render, "SHADER-RECOMPILED"), 1u);
  EXPECT_EQ(again(render), (Rgb{.75f, .75f, .75f}));
  // written again as it was: nothing to do
  write("shown.osl", "shader shown(output color result = 0) { result = .75; }");
  again(render);
  EXPECT_EQ(render.renderer().statistics().shadersCompiled, 2u);
  // new parameters are those of the new text
  write("shown.osl", "shader shown(color c = color(1, 0, .5), output color result = 0) { result = c; }");
  EXPECT_EQ(again(render), (Rgb{1, 0, .5f}));
  EXPECT_FALSE(exists("shown.oso"));
}

TEST_F(ShaderFiles, AnIncludedFileIsPartOfTheShader) {
  write("level.h", "#define LEVEL .25\n");
  write("shown.osl", "#include \"level.h\"\nshader shown(output color result = 0) { result = LEVEL; }");
  SceneRender render(requestOf(network_));
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(middleOf(render), (Rgb{.25f, .25f, .25f}));
  write("level.h", "#define LEVEL .5\n");
  EXPECT_EQ(again(render), (Rgb{.5f, .5f, .5f}));
  EXPECT_EQ(told(render, "SHADER-RECOMPILED"), 1u);
}

TEST_F(ShaderFiles, WhatIsBrokenIsToldOnceForEachState) {
  write("shown.osl", "#include \"level.h\"\nshader shown(output color result = 0) { result = LEVEL; }");
  SceneRender render(requestOf(network_));
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(told(render, "SHADER-COMPILE"), 1u);
  EXPECT_EQ(again(render), (Rgb{1, 0, 1}));
  EXPECT_EQ(told(render, "SHADER-COMPILE"), 1u);
  EXPECT_EQ(told(render, "SHADER-RECOMPILED"), 0u);
  // mended by a file that was not there
  write("level.h", "#define LEVEL .5\n");
  EXPECT_EQ(again(render), (Rgb{.5f, .5f, .5f}));
  EXPECT_EQ(told(render, "SHADER-RECOMPILED"), 1u);
}

TEST_F(ShaderFiles, CompiledShadersAreWrittenWhereAsked) {
  write("level.h", "#define LEVEL .25\n");
  write("shown.osl", "#include \"level.h\"\nshader shown(output color result = 0) { result = LEVEL; }");
  age("level.h", 100);
  age("shown.osl", 100);
  RenderRequest r = requestOf(network_);
  r.rib = "Option \"shader\" \"int cache\" [1]\n" + r.rib;
  {
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    EXPECT_EQ(middleOf(render), (Rgb{.25f, .25f, .25f}));
    EXPECT_TRUE(render.messages().empty());
    ASSERT_TRUE(exists("shown.oso"));
    // what was compiled in memory stays what is used
    again(render);
    EXPECT_EQ(render.renderer().statistics().shadersCompiled, 1u);
  }
  // the compiled one is read while it is newer than all of its sources
  std::string text;
  {
    std::ifstream in(folder_ + "/shown.oso");
    text.assign(std::istreambuf_iterator<char>(in), {});
  }
  for (size_t at = text.find("0.25"); at != std::string::npos; at = text.find("0.25", at))
    text.replace(at, 4, "0.75");
  write("shown.oso", text);
  const auto shown = [&] {
    SceneRender render(requestOf(network_));
    EXPECT_TRUE(render.messages().empty());
    return middleOf(render);
  };
  EXPECT_EQ(shown(), (Rgb{.75f, .75f, .75f}));
  age("level.h", -100);
  EXPECT_EQ(shown(), (Rgb{.25f, .25f, .25f}));
  age("level.h", 100);
  EXPECT_EQ(shown(), (Rgb{.75f, .75f, .75f}));
  age("shown.osl", -100);
  EXPECT_EQ(shown(), (Rgb{.25f, .25f, .25f}));
  // alone it is as good
  fs::remove(folder_ + "/shown.osl");
  EXPECT_EQ(shown(), (Rgb{.75f, .75f, .75f}));
}

TEST_F(ShaderFiles, ASourceStandsInForACompiledShaderThatIsRefused) {
  write("shown.osl", "shader shown(output color result = 0) { result = .5; }");
  age("shown.osl", 100);
  write("shown.oso",
        "OpenShadingLanguage 1.00\nshader shown\noparam\tcolor\tresult\t0 0 0\ncode ___main___\n\tnonsense\n");
  SceneRender render(requestOf(network_));
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(middleOf(render), (Rgb{.5f, .5f, .5f}));
  EXPECT_EQ(told(render, "SHADER-OSO"), 1u);
  EXPECT_EQ(told(render, "SHADER-COMPILE"), 0u);
  EXPECT_EQ(again(render), (Rgb{.5f, .5f, .5f}));
  EXPECT_EQ(told(render, "SHADER-OSO"), 1u);
  write("shown.osl", "shader shown(output color result = 0) { result = .75; }");
  EXPECT_EQ(again(render), (Rgb{.75f, .75f, .75f}));
}

}  // namespace
}  // namespace kinora::tests
