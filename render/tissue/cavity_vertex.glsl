out vec3 ray_W;
void main() {
  vec2 clip = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  ray_W = axis_W.xyz + clip.x * right_W.xyz + clip.y * up_W.xyz;
  gl_Position = vec4(clip, 1.0, 1.0);
}
