import numpy as np
from numpy.polynomial.legendre import leggauss
def total(w):
    D=(2*(1-w)+w)/3; s=np.sqrt((1-w)/D); zb=2*D
    x,wt=leggauss(400)
    # r = e^a, t = e^b
    def nodes(lo,hi): return .5*(hi-lo)*x+.5*(hi+lo), .5*(hi-lo)*wt
    a,wa=nodes(np.log(1e-9),np.log(60/max(s,.05))); b,wb=nodes(np.log(1e-9),np.log(45.))
    r=np.exp(a)[:,None]; t=np.exp(b)[None,:]
    dr=np.hypot(r,t); zv=t+2*zb; dv=np.hypot(r,zv)
    phi=(np.exp(-s*dr)/dr-np.exp(-s*dv)/dv)/(4*np.pi*D)
    E=(t*(1+s*dr)*np.exp(-s*dr)/dr**3+zv*(1+s*dv)*np.exp(-s*dv)/dv**3)/(4*np.pi)
    R=w*w*np.exp(-t)*(1-np.exp(-2*(dr+t)))*(phi/4+E/2)
    m=np.sum(2*np.pi*r*r*t*R*wa[:,None]*wb[None,:])
    return m, m+.5*w*(1-np.log(2))
for w in (.2,.5,.9,.99): print(w,total(w))
