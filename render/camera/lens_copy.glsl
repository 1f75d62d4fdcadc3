in vec2 place;
uniform sampler2D picture;
out vec4 colour;
void main() { colour = textureLod(picture, place, 0.0); }
