void main() { Paint(value, 0.92); }
