const int kMaxTools = 4;
layout(std140) uniform Frame {
  mat4 clip_from_world;
  vec4 lens_W;                   // position
  vec4 light_W;                  // position; w: intensity, m^2
  vec4 axis_W;                   // unit viewing axis
  vec4 right_W;                  // the ray of clip position (x, y) is axis + x right + y up
  vec4 up_W;
  vec4 circle_px;                // centre, radius, width of the soft edge
  vec4 tool_tip_W[kMaxTools];    // position; w: radius of the tip, 0 without a tool
  vec4 tool_axis_W[kMaxTools];   // unit, from the tip along the shaft; w: radius of the shaft
};
