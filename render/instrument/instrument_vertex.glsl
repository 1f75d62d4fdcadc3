layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 world_from_mesh;   // rigid
out vec3 p_W;
out vec3 normal_W;
out float along;                // z in the tool frame, jaws closed
void main() {
  along = position.z;
  vec4 p = world_from_mesh * vec4(position, 1.0);
  p_W = p.xyz;
  normal_W = mat3(world_from_mesh) * normal;
  gl_Position = clip_from_world * p;
}
