// PxrSeExpr: the renderer translates the expression and runs it as a shader, with any further parameters of the node as
// variables. What stands here is what a host without a shading language shows: magenta.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrSeExpr/PxrSeExpr.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

constexpr Param kParams[] = {
    param::color("colorInput1", 0.f).help("Variable colorInput1 of the expression."),
    param::color("colorInput2", 0.f).help("Variable colorInput2."),
    param::color("colorInput3", 0.f).help("Variable colorInput3."),
    param::color("colorInput4", 0.f).help("Variable colorInput4."),
    param::number("floatInput1", 0.f).help("Variable floatInput1."),
    param::number("floatInput2", 0.f).help("Variable floatInput2."),
    param::number("floatInput3", 0.f).help("Variable floatInput3."),
    param::number("floatInput4", 0.f).help("Variable floatInput4."),
    param::string("expression", "")
        .help("Assignments and conditions, then the result, in SeExpr's language. Parameters of any other name are "
              "variables too, given or connected; so are P, Pobj, Nn, Ngn, Vn, VLen, Tn, Cs, s, t, u, v, w, objectId "
              "and time. A broken expression is told with its place, and what it feeds is magenta."),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultF"),
};

struct PxrSeExpr {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const float magenta[3] = {1, 0, 1};
    args->outputs[0] = constantValue(*c, 3, magenta);
    shareComponents(*args, 0);
    shareComponent(args->outputs[0], 0, args->outputs[4]);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrSeExpr, .help = "An expression in SeExpr's language.", .params = kParams)
