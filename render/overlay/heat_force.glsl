uniform int spot_count;
uniform vec4 spots[MAX_SPOTS];    // position, radius
uniform float forces[MAX_SPOTS];  // over the full scale
void main() {
  float sum = 0.0, weights = 0.0, kernel = 0.0;
  for (int i = 0; i < spot_count; ++i) {
    float k = cos(1.5707963 * min(distance(p_W, spots[i].xyz) / spots[i].w, 1.0));
    sum += k * forces[i];
    weights += k;
    kernel = max(kernel, k);
  }
  if (kernel <= 0.001) discard;
  Paint(sum / weights, 0.95 * smoothstep(0.0, 0.8, kernel));
}
