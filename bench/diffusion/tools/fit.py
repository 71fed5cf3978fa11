import numpy as np
from scipy.optimize import least_squares
d=np.loadtxt('/tmp/diffusion/alb.txt'); s=d[:,0]
for col,name in ((1,'diffuse'),(2,'normal')):
    A=d[:,col]
    ok=(A>1e-4)&(A<1-1e-5); S=s[ok]; a=A[ok]
    p=S/(1-a)
    dAds=np.gradient(A,s)[ok]
    w=np.abs(dAds)/(a*(1-a))   # logit weight per unit s
    for (m,n) in ((2,2),(3,2),(3,3),(4,3)):
        # p = (1 + sum c a^i)/(1+ sum e a^j): logit err = w*(1-a)*dp
        W=w*(1-a); R=np.ones_like(a); q=np.ones_like(a)
        best=None
        for it in range(400):
            M=np.column_stack([a**i for i in range(1,m+1)]+[-p*a**j for j in range(1,n+1)])
            ww=W*R/np.abs(q)
            c,*_=np.linalg.lstsq(M*ww[:,None],(p-1)*ww,rcond=None)
            num=1+sum(c[i-1]*a**i for i in range(1,m+1)); q=1+sum(c[m+j-1]*a**j for j in range(1,n+1))
            err=W*(num/q-p); e=np.max(np.abs(err))
            if best is None or e<best[0]: best=(e,c.copy())
            R*= (np.abs(err)/e+0.02)**0.3; R/=R.max()
        print(name,m,n,best[0],list(best[1]))
