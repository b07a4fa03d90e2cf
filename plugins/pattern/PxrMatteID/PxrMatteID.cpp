// PxrMatteID: mattes of objects in the channels MatteID0 ... MatteID7. The renderer runs it as a shader, which can ask for
// attributes; what stands here is what a host without a shading language gives: nothing.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrMatteID/PxrMatteID.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

#define KINORA_MATTE(n)                                                                                              \
  param::color("matteTexture" #n, 0.f)                                                                               \
      .help("What the display channel MatteID" #n " shows of the surface: the object's attribute user:MatteID" #n    \
            " times this, the attribute alone where this is 0 0 0 and not connected, and this alone where there is " \
            "no such attribute.")
constexpr Param kParams[] = {
    param::make(Type::Int, "inputAOV", 0, 0, 0).help("Another such node, which is then there as well."),
    param::flag("enable", true).help("0: its channels are black."),
    KINORA_MATTE(0),
    KINORA_MATTE(1),
    KINORA_MATTE(2),
    KINORA_MATTE(3),
    KINORA_MATTE(4),
    KINORA_MATTE(5),
    KINORA_MATTE(6),
    KINORA_MATTE(7),
    param::output(Type::Int, "resultAOV"),
};
#undef KINORA_MATTE

struct PxrMatteID {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const float none = 0.f;
    args->outputs[0] = constantValue(*c, 1, &none);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrMatteID,
               .help =
                   "Mattes in the display channels MatteID0 to MatteID7, at what the camera sees. It is connected to "
                   "utilityPattern or inputAOV of the material.",
               .params = kParams)
