/* Blinn-Phong with the light at the eye, two-sided: light, view and half vector are one. A zero gradient has no side,
 * so only the ambient part is left. */
uniform mat3 normal_matrix; /* gradient in the level's index space -> world: inverse transpose */
uniform vec4 material;      /* ambient, diffuse, specular, shininess */

vec3 shade(vec3 rgb, vec3 gradient, vec3 view)
{
    vec3 n = normal_matrix * gradient;
    float largest = max(abs(n.x), max(abs(n.y), abs(n.z)));
    if (!(largest > 0.0))
        return rgb * material.x;
    n = normalize(n / largest);
    float facing = min(abs(dot(n, view)), 1.0);
    float highlight = facing > 0.0 ? pow(facing, material.w) : 0.0;
    return rgb * (material.x + material.y * facing) + material.z * highlight;
}
